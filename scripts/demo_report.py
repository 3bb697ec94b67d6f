#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes one self-contained HTML page from the --report files of stages and from pictures.

The sections come in the order of the arguments. Python's standard library only.
"""

import argparse
import base64
import html
import json
import mimetypes
import os
import sys

STYLE = """
:root { color-scheme: light dark; --line: #8884; --soft: #888; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1, h2 { line-height: 1.2; }
figure { margin: 2rem 0; }
figure img { display: block; width: 100%; height: auto; background: #fff; }
figcaption, .soft { color: var(--soft); }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { border-bottom: 1px solid var(--line); padding: .25rem .75rem .25rem 0; text-align: left;
         vertical-align: top; }
td.number, th.number { text-align: right; }
details { margin: .75rem 0; }
summary { cursor: pointer; font-weight: 600; }
.warning { border-left: 4px solid #d90; padding-left: .75rem; }
"""


def escape(value):
    return html.escape(str(value))


def number_text(value):
    """A number as a person writes it: 20400000 -> 20,400,000; 0.123456 -> 0.1235."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value)
    if isinstance(value, int) or (value == int(value) and abs(value) < 1e15):
        return f"{int(value):,}"
    return f"{value:,.1f}" if abs(value) >= 1000 else f"{value:.4g}"


def bytes_text(count):
    for unit, size in (("GiB", 2**30), ("MiB", 2**20), ("KiB", 2**10)):
        if count >= size:
            return f"{count / size:.1f} {unit}"
    return f"{count} B"


def value_html(value):
    """Any JSON value: objects as tables, lists of objects as one table with a column per key."""
    if isinstance(value, dict):
        return table_of(value.items())
    if isinstance(value, list) and value and all(isinstance(row, dict) for row in value):
        keys = list(dict.fromkeys(key for row in value for key in row))
        head = "".join(f"<th>{escape(key)}</th>" for key in keys)
        rows = "".join(
            "<tr>" + "".join(f"<td>{value_html(row.get(key, ''))}</td>" for key in keys) + "</tr>"
            for row in value)
        return f"<div class='wide'><table><tr>{head}</tr>{rows}</table></div>"
    if isinstance(value, list):
        return escape(", ".join(number_text(entry) for entry in value))
    return escape(number_text(value))


def table_of(pairs):
    rows = "".join(f"<tr><th>{escape(name)}</th><td>{value_html(value)}</td></tr>"
                   for name, value in pairs)
    return f"<div class='wide'><table>{rows}</table></div>"


def files_text(files):
    total = sum(entry.get("bytes", 0) for entry in files)
    return f"{len(files)} ({bytes_text(total)})" if files else "0"


def overview(reports):
    head = ("<tr><th>stage</th><th>read</th><th>wrote</th><th class='number'>seconds</th>"
            "<th class='number'>peak memory</th><th class='number'>warnings</th></tr>")
    rows = "".join(
        f"<tr><td>{escape(report['tool'])}</td><td>{files_text(report['inputs'])}</td>"
        f"<td>{files_text(report['outputs'])}</td>"
        f"<td class='number'>{report['seconds']:.1f}</td>"
        f"<td class='number'>{bytes_text(report['peak_memory_bytes'])}</td>"
        f"<td class='number'>{len(report['warnings'])}</td></tr>" for report in reports)
    return f"<div class='wide'><table>{head}{rows}</table></div>"


def stage_section(report):
    parts = [f"<h2>{escape(report['tool'])}</h2>"]
    parts += [f"<p class='warning'>{escape(text)}</p>" for text in report["warnings"]]
    shown = (("Counts", report["counts"], True), ("Quality", report["quality"], True),
             ("Steps", report["steps"], False), ("Parameters", report["parameters"], False))
    for title, value, is_open in shown:
        if value:
            opened = " open" if is_open else ""
            parts.append(f"<details{opened}><summary>{title}</summary>{value_html(value)}</details>")
    return "".join(parts)


def picture_html(argument):
    path, _, caption = argument.partition("=")
    kind = mimetypes.guess_type(path)[0]
    if kind not in ("image/png", "image/jpeg"):
        raise ValueError(f"{path}: is neither PNG nor JPEG")
    with open(path, "rb") as file:
        data = base64.b64encode(file.read()).decode("ascii")
    return (f"<figure><img alt='{escape(caption)}' src='data:{kind};base64,{data}'>"
            f"<figcaption>{escape(caption)}</figcaption></figure>")


def read_report(path):
    with open(path, encoding="utf-8") as file:
        report = json.load(file)
    wanted = ("tool", "version", "machine", "started", "seconds", "peak_memory_bytes", "parameters",
              "inputs", "outputs", "counts", "steps", "quality", "warnings")
    lacking = [key for key in wanted if key not in report]
    if lacking:
        raise ValueError(f"{path}: is no stage report, it lacks {', '.join(lacking)}")
    return report


def page(title, text, reports, pictures):
    first = reports[0]
    machine = first["machine"]
    total = sum(report["seconds"] for report in reports)
    facts = (f"{first['version']} on {machine['cpu']}, {machine['cores']} cores, "
             f"{bytes_text(machine['memory_bytes'])}, {machine['os']}; {first['started']}; "
             f"{total:.0f} s in all stages")
    return (f"<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'>"
            f"<meta name='viewport' content='width=device-width, initial-scale=1'>"
            f"<title>{escape(title)}</title><style>{STYLE}</style></head><body>"
            f"<h1>{escape(title)}</h1><p>{escape(text)}</p><p class='soft'>{escape(facts)}</p>"
            f"{''.join(pictures)}<h2>What ran</h2>{overview(reports)}"
            f"{''.join(stage_section(report) for report in reports)}</body></html>\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("reports", nargs="+", metavar="REPORT.json")
    parser.add_argument("-o", "--output", required=True, metavar="PAGE.html")
    parser.add_argument("--title", required=True)
    parser.add_argument("--text", default="", help="one paragraph under the title")
    parser.add_argument("--picture", action="append", default=[], metavar="FILE=CAPTION")
    arguments = parser.parse_args()
    try:
        content = page(arguments.title, arguments.text,
                       [read_report(path) for path in arguments.reports],
                       [picture_html(picture) for picture in arguments.picture])
        with open(arguments.output + ".part", "w", encoding="utf-8") as file:
            file.write(content)
        os.replace(arguments.output + ".part", arguments.output)
    except (OSError, ValueError) as error:
        print(f"{parser.prog}: error: {error}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
