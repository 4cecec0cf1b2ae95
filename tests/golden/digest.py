"""Digests of a program's outputs: bytes, pixels or numbers, whichever its kind of file is read for."""

import base64
import hashlib
import html
import itertools
import re
import struct
import zlib
from pathlib import Path

# Files programs read: every byte counts.
BYTES = {".tum", ".csv", ".g2o", ".pgm", ".yaml", ".mcap", ".bag", ".bin", ".log", ".carmen",
         ".checkpoint"}

NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+(?:\.\d+)?(?:[eE][-+]?\d+)?|(?:nan|inf)\b)")
DRAWN_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")

# Lines of every program that are measurements of the run and not of its result: (pattern, reason).
MEASURED = [
    (r"^.*(?: \d+ %, \d+:\d\d left| \.\.\.| done in [\d.]+ s)$", "progress line"),
    (r"^took\b.*$", "run time"),
    (r"^(a|per) scan +\d+ us$", "run time"),
    (r"^peak memory\b.*$", "memory of the process"),
    (r"^(held|memory) +[\d.]+ MiB$", "memory of the map, which follows the layout of its types"),
]


class Digest:
    """kind, size (bytes, pixels or how many numbers), sha256, and the numbers where it has some."""

    def __init__(self, kind, size, sha256, numbers=None):
        self.kind, self.size, self.sha256, self.numbers = kind, size, sha256, numbers

    def text(self):
        return f"{self.kind} {self.size} {self.sha256}"


def of_bytes(content):
    return Digest("bytes", len(content), hashlib.sha256(content).hexdigest())


def of_numbers(numbers):
    # -0 and 0 are told apart: a changed sign is a changed result.
    joined = "\n".join(numbers).encode()
    return Digest("numbers", len(numbers), hashlib.sha256(joined).hexdigest(), numbers)


def numbers_of_text(text, left_out):
    """Numbers of a text in order, without its paths and without what `left_out` matches."""
    text = re.sub(r"\{(?:data|out|inputs|bin)\}[^\s,;:'\")]*", "", text)
    for pattern, _ in itertools.chain(MEASURED, left_out):
        text = re.sub(pattern, "", text, flags=re.MULTILINE)
    return NUMBER.findall(text.replace("\u2212", "-"))


def _unfiltered(scanlines, stride, step):
    """Rows of a PNG without their filters (PNG specification, section 9)."""
    above = bytes(stride)
    for at in range(0, len(scanlines), stride + 1):
        kind, row = scanlines[at], bytearray(scanlines[at + 1:at + 1 + stride])
        if kind == 1:
            for channel in range(step):
                row[channel::step] = bytes(
                    v & 255 for v in itertools.accumulate(row[channel::step]))
        elif kind == 2:
            row = bytearray((a + b) & 255 for a, b in zip(row, above))
        elif kind == 3:
            for i in range(stride):
                left = row[i - step] if i >= step else 0
                row[i] = (row[i] + ((left + above[i]) >> 1)) & 255
        elif kind == 4:
            for i in range(stride):
                a, b, c = (row[i - step], above[i], above[i - step]) if i >= step else (
                    0, above[i], 0)
                pa, pb, pc = abs(b - c), abs(a - c), abs(a + b - c - c)
                row[i] = (row[i] + (a if pa <= pb and pa <= pc else b if pb <= pc else c)) & 255
        above = bytes(row)
        yield above


def of_png(content):
    """Size and pixels; other PNGs than 8-bit ones without interlace by their bytes."""
    width, height, depth, colour, _, _, interlace = struct.unpack(">IIBBBBB", content[16:29])
    channels = {0: 1, 2: 3, 4: 2, 6: 4}.get(colour)
    if depth != 8 or interlace or channels is None:
        return of_bytes(content)
    data, at = b"", 8
    while at < len(content):
        length, name = struct.unpack(">I4s", content[at:at + 8])
        if name == b"IDAT":
            data += content[at + 8:at + 8 + length]
        at += 12 + length
    digest = hashlib.sha256(f"{width} {height} {channels}".encode())
    for row in _unfiltered(zlib.decompress(data), width * channels, channels):
        digest.update(row)
    return Digest("pixels", width * height, digest.hexdigest())


def numbers_of_drawing(svg):
    """Coordinates of an SVG drawing and the figures at its axes."""
    numbers = []
    for part in re.findall(r'\b(?:d|points|c?x|c?y|[xy][12]|r|width|height|viewBox|transform)='
                           r'"([^"]*)"|>\s*([-+\u2212\d.eE]+)\s*</text>', svg):
        numbers += DRAWN_NUMBER.findall("".join(part).replace("\u2212", "-"))
    return numbers


def of_report(text, left_out):
    """Facts, cells, drawings and pictures of an HTML report; headings and sentences may change."""
    numbers = []
    blocks = re.compile(r'<div><dt>(?P<dt>.*?)</dt>\s*<dd>(?P<dd>.*?)</dd>|<tr>(?P<row><td>.*?)</tr>|'
                        r'<svg(?P<svg>.*?)</svg>|data:image/png;base64,(?P<png>[^"]*)', re.DOTALL)
    for block in blocks.finditer(text):
        if block["dt"]:
            line = f"{block['dt']} {block['dd']}"
            numbers += numbers_of_text(html.unescape(line), left_out)
        elif block["row"]:
            line = re.sub(r"</td>\s*<td>", "  ", block["row"])
            numbers += numbers_of_text(html.unescape(re.sub(r"<[^>]*>", "", line)), left_out)
        elif block["svg"]:
            numbers += numbers_of_drawing(block["svg"])
        else:
            numbers.append(of_png(base64.b64decode(block["png"])).sha256)
    return of_numbers(numbers)


def without_folders(text, places):
    """`places` are the folders its paths may begin with, by name."""
    for name, folder in places.items():
        text = text.replace(folder, "{" + name + "}")
    return text


def of_text(text, places, left_out):
    return of_numbers(numbers_of_text(without_folders(text, places), left_out))


def of_file(path, places, left_out):
    path = Path(path)
    if path.suffix in BYTES:
        return of_bytes(path.read_bytes())
    if path.suffix == ".png":
        return of_png(path.read_bytes())
    text = path.read_text(errors="replace")
    if path.suffix == ".html":
        return of_report(without_folders(text, places), left_out)
    if path.suffix == ".svg":
        return of_numbers(numbers_of_drawing(text))
    return of_text(text, places, left_out)
