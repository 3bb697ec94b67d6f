# SPDX-License-Identifier: GPL-3.0-or-later
"""Pieces of a self-contained HTML page: numbers, tables, pictures."""

import base64
import html
import mimetypes

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
.failure { border-left: 4px solid #c22; padding-left: .75rem; }
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


def seconds_text(seconds):
    return f"{seconds:,.1f}"


def list_text(values, most=12):
    """A list as text, cut where it names a survey's thousands of files."""
    shown = ", ".join(map(str, values[:most]))
    return shown if len(values) <= most else f"{shown} and {len(values) - most:,} more"


def table(head, rows):
    """head: (title, is_number) per column; rows of values, numbers written as people do."""
    titles = "".join(f"<th{' class=number' if is_number else ''}>{escape(title)}</th>"
                     for title, is_number in head)
    body = ""
    for row in rows:
        body += "<tr>" + "".join(
            f"<td{' class=number' if is_number else ''}>{escape(number_text(value))}</td>"
            for value, (_, is_number) in zip(row, head)) + "</tr>"
    return f"<div class='wide'><table><tr>{titles}</tr>{body}</table></div>"


def folded(title, content, is_open=False):
    opened = " open" if is_open else ""
    return f"<details{opened}><summary>{escape(title)}</summary>{content}</details>"


def paragraph(text, kind=""):
    return f"<p{f' class={kind}' if kind else ''}>{escape(text)}</p>"


def link(target, text):
    return f"<p><a href='{escape(target)}'>{escape(text)}</a></p>"


def picture(picture_path, caption):
    kind = mimetypes.guess_type(picture_path)[0]
    if kind not in ("image/png", "image/jpeg"):
        raise ValueError(f"{picture_path}: is neither PNG nor JPEG")
    with open(picture_path, "rb") as file:
        data = base64.b64encode(file.read()).decode("ascii")
    return (f"<figure><img alt='{escape(caption)}' src='data:{kind};base64,{data}'>"
            f"<figcaption>{escape(caption)}</figcaption></figure>")


def document(title, body):
    return (f"<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'>"
            f"<meta name='viewport' content='width=device-width, initial-scale=1'>"
            f"<title>{escape(title)}</title><style>{STYLE}</style></head><body>"
            f"<h1>{escape(title)}</h1>{body}</body></html>\n")
