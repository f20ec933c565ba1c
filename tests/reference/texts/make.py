"""Writes the files of this folder. Needs numpy and pyuff 2.5.8 (pip install pyuff numpy); run it in this folder."""

import gzip
import io
import zipfile

import numpy as np
import pyuff


def ramp(channel, count=50):
    """Numbers with an exact decimal, other ones for each channel."""
    return [channel + 0.125 * i for i in range(count)]


def text(name, lines, encoding="utf-8", ends="\r\n", mark=b""):
    with open(name, "wb") as file:
        file.write(mark + (ends.join(lines) + ends).encode(encoding))


def comma(value):
    return f"{value:g}".replace(".", ",")


# a laboratory in Germany, one in China
rows = [f"20.11.2026 09:00:{i // 10:02d},{i % 10}00;{comma(21.5)};{comma(0.125 * i)}" for i in range(30)]
text("latin1.csv", ["Messung Nr. 7", "Prüfer;Müller", "Zeit;Temperatur;Beschl. X", ";°C;m/s²", *rows], "latin-1")
rows = [f"2026-11-20 09:00:{i // 10:02d}.{i % 10}00;21.5;{0.125 * i:g}" for i in range(30)]
text("gb18030.csv", ["时间;温度;加速度X", ";℃;g", *rows], "gb18030")
text("utf16.csv", ["时间;温度;加速度X", ";℃;g", *rows], "utf-16-le", mark=b"\xff\xfe")

# robots: rostopic echo -p, and a table with the stamp in two columns
rows = [f"{1700000000000000000 + 5000000 * i + 77777},{i},{1700000000000000000 + 5000000 * i},imu,{0.125 * i:g}" for i in range(30)]
text("rostopic.csv", ["%time,field.header.seq,field.header.stamp,field.header.frame_id,field.angular_velocity.x", *rows], ends="\n")

# LabVIEW: one x column; decimal comma; no x column and two segments
head = ["LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab", "Decimal_Separator\t{mark}",
        "Multi_Headings\t{multi}", "X_Columns\t{columns}", "Time_Pref\tRelative", "Operator\tlab", "Date\t2026/11/20",
        "Time\t09:00:00", "***End_of_Header***\t", "\t"]
segment = ["Channels\t2\t\t", "Samples\t25\t25\t", "Date\t2026/11/20\t2026/11/20\t", "Time\t09:00:{second}\t09:00:{second}\t",
           "Y_Unit_Label\tg\tdeg/s\t", "X_Dimension\tTime\tTime\t", "X0\t0.0\t0.0\t", "Delta_X\t{step}\t{step}\t",
           "***End_of_Header***\t\t\t", "X_Value\tax\tgyro\tComment"]


def lvm(name, mark, columns, segments):
    fill = dict(mark=mark, multi="Yes" if segments > 1 else "No", columns=columns)
    lines = [line.format(**fill) for line in head]
    for part in range(segments):
        step = "0.010000".replace(".", mark)
        lines += [line.format(second=f"{part:02d}.000000", step=step).replace("0.0\t", f"0{mark}0\t") if line.startswith("X0")
                  else line.format(second=f"{part:02d}.000000", step=step) for line in segment]
        for i in range(25):
            k = 25 * part + i
            x = f"{0.01 * i:.6f}" if columns == "One" else ""
            lines.append("\t".join(cell.replace(".", mark) for cell in (x, f"{1 + 0.125 * k:.6f}", f"{2 + 0.125 * k:.6f}")))
        lines.append("")
    text(name, lines)


lvm("one_x.lvm", ".", "One", 1)
lvm("comma.lvm", ",", "One", 1)
lvm("two_segments.lvm", ".", "No", 2)

# universal file: single and double precision, even and uneven, and a spectrum, which is no recording
uff = pyuff.UFF("time.uff")
time = 0.005 * np.arange(50)
common = dict(func_type=1, rsp_node=4, abscissa_spec_data_type=17, abscissa_axis_units_lab="s", ordinate_spec_data_type=12,
              orddenom_spec_data_type=0, binary=0, ref_node=0, ref_dir=0)
uff.write_sets([pyuff.prepare_58(id1="ax", rsp_dir=1, ordinate_axis_units_lab="m/s^2", abscissa_spacing=1, abscissa_min=0.0, abscissa_inc=0.005, x=time, data=np.array(ramp(1)), **common)], "overwrite")
uff.write_sets([pyuff.prepare_58(id1="az", rsp_dir=3, ordinate_axis_units_lab="g", x=time, data=np.array(ramp(3)), **common)], "add")
spectrum = dict(common, func_type=4, abscissa_spec_data_type=18)
uff.write_sets([pyuff.prepare_58(id1="frf", rsp_dir=3, ordinate_axis_units_lab="g", x=time, data=np.array(ramp(3)) * (1 + 1j), **spectrum)], "add")

# Sensor Logger for Android
def sensor(rows_of, shift=0, count=50):
    lines = ["time,seconds_elapsed,z,y,x"]
    lines += [f"{1700000000000000000 + shift + 10000000 * i},{1e-9 * shift + 0.01 * i:.9f},{','.join(f'{v:g}' for v in rows_of(i))}" for i in range(count)]
    return "\n".join(lines) + "\n"


files = {
    "Metadata.csv": "version,device name,recording time,platform,appVersion,standardisation\n1,phone,2023-11-14_22-13-20,android,1.30,false\n",
    "Accelerometer.csv": sensor(lambda i: (0.5, 0.25, 0.125)),
    "TotalAcceleration.csv": sensor(lambda i: (9.75, 0.5, 0.125 * i)),
    "Gyroscope.csv": sensor(lambda i: (7, 7, 7)),
    "GyroscopeUncalibrated.csv": sensor(lambda i: (3, 2, 1 + 0.125 * i), shift=2500000),
}
with zipfile.ZipFile("sensor_logger.zip", "w", zipfile.ZIP_DEFLATED) as archive:
    for name, content in files.items():
        archive.writestr(zipfile.ZipInfo(name, (2026, 11, 20, 9, 0, 0)), content, zipfile.ZIP_DEFLATED)

# packed tables
plain = "time[s],a[deg/h]\n" + "".join(f"{0.01 * i:.2f},{0.125 * i:g}\n" for i in range(50))
with open("plain.csv.gz", "wb") as file:
    file.write(gzip.compress(plain.encode(), mtime=0))
for name, names in {"one.zip": ["data/plain.csv"], "two.zip": ["a.csv", "b.csv"]}.items():
    with zipfile.ZipFile(name, "w") as archive:
        for i, inside in enumerate(names):
            kind = zipfile.ZIP_STORED if i == 0 else zipfile.ZIP_DEFLATED
            archive.writestr(zipfile.ZipInfo(inside, (2026, 11, 20, 9, 0, 0)), plain if i == 0 else plain.replace("a[", "b["), kind)
