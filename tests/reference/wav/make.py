"""Writes the files of this folder by Python's own module wave and by scipy.io.wavfile: needs numpy and scipy.

    python3 make.py FOLDER

Sample k of channel c is (100 k + c) (-1)^k in counts of 16 bits, and this times 256 or 65536 for 24 and 32 bits.
"""

import struct
import sys
import wave
from pathlib import Path

import numpy
from scipy.io import wavfile

RATE, FRAMES = 12800, 50
k = numpy.arange(FRAMES)
COUNTS = numpy.stack([(100 * k + c) * (-1) ** k for c in range(3)], axis=1).astype(numpy.int64)


def integers(path, width):
    shift = 8 * (width - 2)
    with wave.open(str(path), "wb") as file:
        file.setnchannels(3)
        file.setsampwidth(width)
        file.setframerate(RATE)
        file.writeframes(b"".join(int(v << shift).to_bytes(width, "little", signed=True) for v in COUNTS.ravel()))


def large(path):
    """RF64: sizes in the chunk ds64; a chunk of an unknown kind and of odd length; a list of texts."""
    data = COUNTS.astype("<i2").tobytes()
    chunks = b"JUNK" + struct.pack("<I", 3) + b"abc\0"
    info = b"INFO" + b"INAM" + struct.pack("<I", 6) + b"shaker"
    chunks += b"LIST" + struct.pack("<I", len(info)) + info
    chunks += b"fmt " + struct.pack("<IHHIIHH", 16, 1, 3, RATE, RATE * 6, 6, 16)
    chunks += b"data" + struct.pack("<I", 0xffffffff) + data
    ds64 = struct.pack("<QQQI", 4 + 36 + len(chunks), len(data), FRAMES, 0)
    path.write_bytes(b"RF64" + struct.pack("<I", 0xffffffff) + b"WAVE" + b"ds64" + struct.pack("<I", len(ds64)) + ds64 + chunks)


def main(folder):
    folder = Path(folder)
    for width in (2, 3, 4):
        integers(folder / f"counts{8 * width}.wav", width)
    wavfile.write(folder / "float32.wav", RATE, (COUNTS / 32768).astype(numpy.float32))
    wavfile.write(folder / "float64.wav", RATE, COUNTS / 32768)
    large(folder / "large.wav")
    for name, scale in (("counts16", 1), ("counts24", 65536), ("counts32", 65536), ("large", 1)):  # scipy widens 24 bits
        rate, data = wavfile.read(folder / f"{name}.wav")
        assert rate == RATE and numpy.array_equal(data, COUNTS * scale), name


if __name__ == "__main__":
    main(*sys.argv[1:])
