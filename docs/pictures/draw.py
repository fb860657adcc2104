#!/usr/bin/env python3
"""The pictures of the documentation, out of the program: make pictures. HEXID names it; chromium takes the picture of a page, pngquant makes
it small.

    machine.svg      joints and legs at neutral, from the configuration's geometry (docs/method.md section 1)
    gap_force.svg    the first picture of a gap report: a leg's force, measured, and by the model before and after
    gap_report.png   the first screen of that report
    live.png         the first screen of the live page, during a run by the wall clock
    live_fault.png   the same on a telephone, during a fault"""
import base64
import html
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile

HEXID = os.path.abspath(os.environ.get("HEXID", "build/hexid"))
HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE.parent.parent / "tests" / "peers"))
from browser import Browser  # noqa: E402

HIDDEN = [f"effects.cylinder_coulomb_friction.force_{way}_n=100" for way in ("extend", "retract")]


def hexid(*arguments, cwd=None):
    return subprocess.run([HEXID, *arguments], check=True, capture_output=True, text=True, cwd=cwd).stdout


def joints():
    """Of the platform and of the base in {M} = {B} at neutral, z down; and the platform's mass centre, the origin."""
    text = hexid("run", "--print-config", "-c", "config/tian2015.yaml")
    value = {key: float(number) for key, number in re.findall(r"^  (\w+): +(-?[\d.e+-]+) +#", text, re.M)}
    alpha, beta, third = value["upper_half_angle_rad"], value["lower_half_angle_rad"], math.pi / 3
    h, height = value["center_height_m"], value["height_m"]
    upper = [-alpha, alpha, 2 * third - alpha, 2 * third + alpha, 4 * third - alpha, 4 * third + alpha]
    lower = [-third + beta, third - beta, third + beta, math.pi - beta, math.pi + beta, 5 * third - beta]
    ring = lambda angles, radius, z: [(radius * math.cos(a), radius * math.sin(a), z) for a in angles]
    return ring(upper, value["upper_radius_m"], h), ring(lower, value["lower_radius_m"], h + height)


def seen(point):
    """Parallel projection from behind, from the left and from above; pixels. Right, down and away are as y, z and x are: no mirror."""
    x, y, z = point
    turn, tilt = math.radians(45), math.radians(20)  # as the live page takes it: no leg hides another
    across, away = x * math.sin(turn) + y * math.cos(turn), x * math.cos(turn) - y * math.sin(turn)
    return 330 + 180 * across, 105 + 180 * (z * math.cos(tilt) - away * math.sin(tilt))


def line(a, b, style):
    (x1, y1), (x2, y2) = seen(a), seen(b)
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" {style}/>'


def word(at, text, dx=0, dy=0, style=""):
    x, y = seen(at)
    return f'<text x="{x + dx:.1f}" y="{y + dy:.1f}" {style}>{html.escape(text)}</text>'


def polygon(points, style):
    return f'<polygon points="{" ".join("%.1f,%.1f" % seen(p) for p in points)}" {style}/>'


def machine():
    upper, lower = joints()
    part = lambda a, b, share: tuple(p + share * (q - p) for p, q in zip(a, b))
    out = ['<svg xmlns="http://www.w3.org/2000/svg" width="440" viewBox="0 0 660 540" font-family="sans-serif" font-size="17" fill="#222">',
           '<rect width="660" height="540" fill="white"/>', polygon(lower, 'fill="#ececec" stroke="#888"')]
    far_first = sorted(range(6), key=lambda i: seen(lower[i])[1])
    for i in far_first:
        out.append(line(upper[i], lower[i], 'stroke="#777" stroke-width="5"'))
        out.append(line(part(lower[i], upper[i], 0.55), lower[i], 'stroke="#2f5d8a" stroke-width="13"'))
    out.append(polygon(upper, 'fill="#f3c98b" fill-opacity="0.85" stroke="#8a5a12" stroke-width="2"'))
    for i in range(6):
        out += ['<circle cx="%.1f" cy="%.1f" r="5"/>' % seen(p) for p in (upper[i], lower[i])]
        out.append(word(part(lower[i], upper[i], 0.28), str(i + 1), -5, 6, 'fill="white" font-weight="bold"'))
    origin = (0.0, 0.0, 0.0)
    for name, end, dx, dy in (("x forward", (0.9, 0, 0), 6, -6), ("y right", (0, 0.9, 0), 8, 6), ("z down", (0, 0, 0.7), 28, 6)):
        out.append(line(origin, end, 'stroke="#b02020" stroke-width="3"'))
        out.append(word(end, name, dx, dy, 'fill="#b02020"'))
    out.append('<circle cx="%.1f" cy="%.1f" r="6" fill="#b02020"/>' % seen(origin))
    (HERE / "machine.svg").write_text("\n".join(out) + "\n</svg>\n")


def report():
    with tempfile.TemporaryDirectory() as work:
        pathlib.Path(work, "config").symlink_to(pathlib.Path("config").resolve())
        pathlib.Path(work, "runs").mkdir()
        quiet = "--set", "lcm.url="
        hidden = [option for setting in HIDDEN for option in ("--set", setting)]
        hexid("run", "--fast", "--set", "sim.engine=closed_form", *quiet, *hidden, "--log", "runs/f.lcm", cwd=work)
        hexid("gap", "--measured", "runs/f.lcm", "-c", "config/tian2015.yaml", *quiet, "-o", "runs/gap", cwd=work)
        page = pathlib.Path(work, "runs", "gap", "report.html")
        first = re.search(r'<img alt="[^"]*" src="data:image/svg\+xml;base64,([^"]*)"', page.read_text()).group(1)
        (HERE / "gap_force.svg").write_bytes(base64.b64decode(first))
        subprocess.run(["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars", f"--user-data-dir={work}/chromium",
                        "--window-size=1240,570", f"--screenshot={HERE / 'gap_report.png'}", f"file://{page}"], check=True, capture_output=True)


def live():
    """In a network of its own, where nobody else's hexid is heard."""
    inside = "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && exec \"$@\""
    user = [] if os.geteuid() == 0 else ["-Ur"]
    subprocess.run(["unshare", "-n", *user, "sh", "-c", inside, "sh", sys.executable, __file__, "live"], check=True)


def live_picture(name, size, moment, *options):
    config = "-c", "config/tian2015.yaml"
    with tempfile.TemporaryDirectory() as work:
        monitor = subprocess.Popen([HEXID, "monitor", *config, "--http", "0"], stdout=subprocess.PIPE, text=True)
        with Browser(work) as page:
            page.size(*size)
            page.open(monitor.stdout.readline().split()[-1])
            run = subprocess.Popen([HEXID, "run", *config, "--rt", "off", *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            page.wait(moment, 200)
            page.picture(HERE / (name + ".png"))
            run.kill()
            run.wait()
        monitor.terminate()
        monitor.wait()


def live_pictures():
    live_picture("live", (1240, 1060), "document.getElementById('doing').textContent.startsWith('test 2 of 6: y, evaluated part, 4')")
    live_picture("live_fault", (420, 700), "document.title.startsWith('FAULT')", "--hal", "fault:freeze@9+60/3;sim:")


if __name__ == "__main__" and sys.argv[1:] == ["live"]:
    live_pictures()
elif __name__ == "__main__":
    machine()
    report()
    live()
    for file in HERE.glob("*.png"):
        subprocess.run(["pngquant", "--force", "--strip", "--output", file, file], check=True)
    for file in sorted(HERE.glob("*.*g")):
        print(f"{file.stat().st_size:7d} {file.relative_to(HERE.parent.parent)}")
