# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a survey's configuration, and says in one line what is wrong with it and where."""

import difflib
import glob
import json
import os

import jsonschema
import yaml


class ConfigError(Exception):
    """What is wrong, "FILE: KEY: problem"."""


class UniqueKeys(yaml.SafeLoader):
    """Refuses a key that stands twice; YAML's default is to take the last one silently."""

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if key in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"the key \"{key}\" stands twice", key_node.start_mark)
            seen.add(key)
        return super().construct_mapping(node, deep)


def load_yaml(config_path):
    try:
        with open(config_path, encoding="utf-8") as file:
            return yaml.load(file, Loader=UniqueKeys)
    except OSError as error:
        raise ConfigError(f"{config_path}: {error.strerror.lower()}") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{config_path}: is no text in UTF-8") from error
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f"line {mark.line + 1}: " if mark else ""
        raise ConfigError(
            f"{config_path}: {where}{getattr(error, 'problem', None) or 'is no valid YAML'}"
        ) from error


def key_text(keys):
    text = ""
    for key in keys:
        text += f"[{key}]" if isinstance(key, int) else (f".{key}" if text else str(key))
    return text


def unknown_key(error):
    """The key that additionalProperties refuses, and what may have been meant."""
    known = list(error.schema.get("properties", {}))
    key = next(key for key in error.instance if key not in known)
    near = difflib.get_close_matches(str(key), known, n=1)
    hint = f", did you mean \"{near[0]}\"?" if near else f"; known are {', '.join(known)}"
    return key_text(list(error.absolute_path) + [key]), f"is no known key{hint}"


def describe(error):
    if error.validator == "additionalProperties":
        where, problem = unknown_key(error)
    elif error.validator == "required":
        missing = next(key for key in error.validator_value if key not in error.instance)
        where, problem = key_text(list(error.absolute_path) + [missing]), "is missing"
    elif error.validator == "dependencies":
        where, problem = next((key, f"needs the section \"{needs[0]}\"")
                              for key, needs in error.validator_value.items()
                              if key in error.instance and needs[0] not in error.instance)
    else:
        where, problem = key_text(error.absolute_path), error.message
        meaning = error.schema.get("description")
        problem += f" ({meaning})" if meaning else ""
    return f"{where}: {problem}" if where else problem


def check(config_path, config, schema_path):
    with open(schema_path, encoding="utf-8") as file:
        schema = json.load(file)
    errors = sorted(jsonschema.Draft7Validator(schema).iter_errors(config),
                    key=lambda error: [str(key) for key in error.absolute_path])
    if errors:
        raise ConfigError(f"{config_path}: {describe(errors[0])}")


def read(config_path, schema_path):
    """The configuration, checked; an empty section counts as none."""
    config = load_yaml(config_path)
    if not isinstance(config, dict):
        raise ConfigError(f"{config_path}: is empty, or no map of keys and values")
    config = {key: {} if value is None else value for key, value in config.items()}
    check(config_path, config, schema_path)
    if config.get("stitch", {}).get("format", "ply") != "ply":
        for key in ("hlod", "compare"):
            if key in config:
                raise ConfigError(f"{config_path}: {key}: reads .ply, not the stitch.format that is "
                                  "asked for")
    return config


def files(config_path, key, patterns, endings):
    """The files that a key's patterns stand for, relative to the configuration's folder, sorted; of
    folders those with one of the endings."""
    folder = os.path.dirname(os.path.abspath(config_path))
    listed = []
    for pattern in patterns:
        full = os.path.join(folder, os.path.expanduser(pattern))
        found = [full] if os.path.exists(full) else glob.glob(full, recursive=True)
        if not found:
            raise ConfigError(f"{config_path}: {key}: {pattern}: no such file")
        for name in found:
            inside = [os.path.join(name, entry) for entry in os.listdir(name)
                      if entry.lower().endswith(endings)] if os.path.isdir(name) else [name]
            if not inside:
                raise ConfigError(f"{config_path}: {key}: {pattern}: holds no "
                                  f"{', '.join(endings)}")
            listed += [os.path.normpath(entry) for entry in inside]
    return sorted(set(listed))
