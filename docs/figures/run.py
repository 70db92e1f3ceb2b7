#!/usr/bin/env python3
"""Prints the figures that README.md, docs/method.md and docs/milling.md state, each from the command that it belongs to.

    cargo build --release --locked
    python3 docs/figures/run.py                # all of them: about ten CPU minutes
    python3 docs/figures/run.py weyrich2009    # those of one group; --list names the groups

Needs Python 3.9 and nothing else. FACETMILL names the program [target/release/facetmill]. Run before a release; a figure in
the text that differs from what stands here is corrected there.
"""
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("FACETMILL", str(ROOT / "target/release/facetmill"))
PICTURES = ROOT / "examples/highlights"
GROUPS = {}


def group(function):
    """A group of figures: its name is the function's, what it is its docstring."""
    GROUPS[function.__name__.replace("_", "-")] = function
    return function


def report(picture, flags="", command="design"):
    """The report of a design of an example picture."""
    with tempfile.TemporaryDirectory() as folder:
        words = [PROGRAM, command, str(PICTURES / f"{picture}.png"), "-o", f"{folder}/plate", "--json", *flags.split()]
        run = subprocess.run(words, capture_output=True, text=True)
        if run.returncode:
            sys.exit(f"{' '.join(words)}\n{run.stderr}")
        return json.loads(run.stdout)


def as_made(picture, design, making):
    """What is said of a plate as a machine makes it."""
    with tempfile.TemporaryDirectory() as folder:
        drawing, plate = str(PICTURES / f"{picture}.png"), f"{folder}/plate"
        said = []
        for words in [
            ["design", drawing, "-o", plate, "--no-verify", *design.split()],
            ["verify", plate, *making.split()],
        ]:
            run = subprocess.run([PROGRAM, *words, "--json"], capture_output=True, text=True, cwd=ROOT)
            if run.returncode:
                sys.exit(f"{' '.join(words)}\n{run.stderr}")
            said.append(json.loads(run.stdout))
        return said[-1]["as_made"]


def tv(figures, blur="1"):
    return figures["tv_incident"][blur]


def seconds(said):
    return said["design"]["seconds"]["total"]


def megabytes(said):
    return said["stl"]["bytes"] / 1e6


def row(*cells):
    print("  " + " | ".join(str(cell) for cell in cells))


@group
def first_example():
    """README, "Two commands": what the first command prints."""
    with tempfile.TemporaryDirectory() as folder:
        picture = PICTURES / "portrait.png"
        words = [PROGRAM, "design", str(picture), "-o", "portrait", "--for-cutter", "ball:0.5"]
        subprocess.run(words, cwd=folder, check=True)


@group
def weyrich2009():
    """README, "Against the 2009 method", and docs/method.md: spiral, half field 45 degrees, 30 x 30 facets."""
    for name, flags in [
        ("random order, Poisson heights", "--method weyrich2009 --arrange random"),
        ("--method weyrich2009", "--method weyrich2009"),
        ("--arrange anneal --level", "--arrange anneal --level"),
        ("--arrange transport", "--arrange transport"),
    ]:
        said = report("spiral", f"--half-field 45 --facets 30x30 {flags}")
        plate = said["design"]
        row(
            f"{name:30}",
            f"A_v {plate['wall_area_ratio']:.4f}",
            f"V {plate['valleys']}",
            f"RMS step {plate['step_rms_pitch']:.4f} pitch",
            f"bounced twice {100 * said['designed']['multi_bounce']:.2f} %",
            f"{seconds(said):.2f} CPU s",
        )


@group
def weyrich2009_seeds():
    """README and docs/method.md: what annealing leaves of random order, seeds 1 to 8."""
    left = []
    for seed in range(1, 9):
        same = f"--half-field 45 --facets 30x30 --no-verify --seed {seed} --method weyrich2009"
        before, after = (report("spiral", same + more)["design"] for more in (" --arrange random", ""))
        left.append([after[key] / before[key] for key in ("wall_area_ratio", "valleys")])
    for name, shares in zip(("A_v", "V"), zip(*left)):
        row(name, f"{min(shares):.2f} to {max(shares):.2f} of random order")


@group
def ring_gallery():
    """README, "Gallery of facets": the ring in four arrangements."""
    for flags in ["--arrange transport", "--cells 3", "--arrange anneal", "--arrange random"]:
        said = report("ring", f"--surface facets --facets 30x30 {flags}")
        plate = said["design"]
        row(
            f"{flags:20}",
            f"steps {plate['step_rms_mm']:.2g} mm",
            f"{plate['inner_valleys']} valleys",
            f"relief {plate['relief_height_mm']:.2f} mm",
            f"bounced twice {100 * said['designed']['multi_bounce']:.2f} %",
        )


@group
def sizes_of_facets():
    """README, --facets: portrait."""
    for facets in ["15x15", "30x30", "60x60", "100x100"]:
        said = report("portrait", f"--facets {facets}")
        row(facets, f"TV(0.5) {tv(said['designed'], '0.5'):.3f}", f"{megabytes(said):.2g} MB", f"{seconds(said):.1f} CPU s")


@group
def samplings():
    """README, --sample: portrait, 900 facets."""
    for sample in ["voronoi", "sobol", "random"]:
        row(sample, f"TV(1) {tv(report('portrait', f'--facets 30x30 --sample {sample}')['designed']):.4f}")


@group
def half_fields():
    """README, --half-field: portrait."""
    for degrees in [10, 20, 40]:
        said = report("portrait", f"--half-field {degrees}")
        row(degrees, f"relief {said['design']['relief_height_mm']:.2f} mm", f"TV(1) {tv(said['designed']):.4f}")


@group
def lights_and_lobes():
    """README, --light, --light-radius, --lobe, --size, --cells, --level, --slope-cap: portrait."""
    for flags in [
        "--light 30,90",
        "--light-radius 0.2665",
        "--lobe 1 --surface facets",
        "--size 100x100",
        "--cells 1",
        "--level",
        "--slope-cap 5",
    ]:
        said = report("portrait", flags)
        figures = said["designed"]
        row(
            f"{flags:26}",
            f"relief {said['design']['relief_height_mm']:.2f} mm",
            f"TV(0.5) {tv(figures, '0.5'):.4f}",
            f"TV(1) {tv(figures):.4f}",
            f"SSIM(1) {figures['ssim']['1']:.3f}",
            f"mount {said['design']['mount_theta_deg']:.2f} deg, {said['design']['mount_phi_deg']:.1f} deg",
            f"cut away {100 * said['highlight']['beyond_cap']:.1f} %",
        )


@group
def grids():
    """README, --grid: portrait, without a cutter and with a ball of 0.5 mm."""
    for grid in [256, 400]:
        plain, cut = (report("portrait", f"--grid {grid} {more}") for more in ("", "--for-cutter ball:0.5"))
        row(
            grid,
            f"{megabytes(plain):.0f} MB",
            f"{seconds(plain):.0f} and {seconds(cut):.0f} CPU s",
            f"as milled TV(1) {tv(cut['as_milled']):.4f}",
        )


@group
def cutters():
    """README, --for-cutter: photograph, as milled."""
    for ball in ["0.5", "1"]:
        said = report("photograph", f"--for-cutter ball:{ball}")
        milled = said["as_milled"]
        row(
            f"ball:{ball}",
            f"TV(0.5) {tv(milled, '0.5'):.4f}",
            f"SSIM(0.5) {milled['ssim']['0.5']:.3f}",
            f"TV(1) {tv(milled):.4f}",
            f"{seconds(said):.0f} CPU s",
        )


@group
def rays():
    """README, --rays: standard error of TV(1), 900 facets."""
    for count in [200_000, 2_000_000, 20_000_000]:
        error = report("portrait", f"--facets 30x30 --rays {count}")["designed"]["error"]
        row(count, f"{tv(error):.6f}")


@group
def both_kinds():
    """README, "One sheet or facets": both kinds at their defaults, as designed and cut by a ball of 0.5 mm."""
    for picture in ["photograph", "portrait", "letter", "star", "spiral", "ring", "word"]:
        said = report(picture, "--for-cutter ball:0.5")
        bare = report(picture, "")
        flat = report(picture, "--surface flat --for-cutter ball:0.5")
        facets = [tv(flat["designed"]), tv(flat["as_milled"])]
        row(
            f"{picture:10}",
            f"designed: facets {facets[0]:.4f}, sheet {tv(bare['designed']):.4f}",
            f"cut: facets {facets[1]:.4f}, sheet {tv(said['as_milled']):.4f}",
        )


@group
def machines():
    """docs/milling.md: portrait, TV(1) / SSIM(0.5) as made, passes 0.02 mm apart."""
    plates = [
        ("--for-cutter ball:0.5", "0"),
        ("--for-cutter ball:0.5", "0.04"),
        ("--for-cutter ball:0.5 --polish 0.04", "0.04"),
        ("--cells 1 --for-cutter ball:2 --polish 0.06", "0.06"),
    ]
    for machine in ["desktop", "desktop-good", "vmc", "vmc-good", "ultraprecision"]:
        making = f"--machine {machine} --stepover 0.02 --polish"
        made = [as_made("portrait", design, f"{making} {polish}") for design, polish in plates]
        row(machine, *(f"{tv(m):.4f} / {m['ssim']['0.5']:.3f}" for m in made), f"{made[0]['finishing_hours']:.1f} h")


@group
def best_machining():
    """docs/milling.md: portrait, what suits each machine."""
    for machine, design, stepover, polish in [
        ("desktop", "--size 100x100 --cells 1 --for-cutter ball:6", 0.1, 0.2),
        ("desktop-good", "--cells 1 --for-cutter ball:2", 0.02, 0.1),
        ("vmc", "--cells 1 --for-cutter ball:2", 0.04, 0.06),
    ]:
        making = f"--machine {machine} --stepover {stepover} --polish {polish}"
        made = as_made("portrait", f"{design} --polish {polish}", making)
        row(machine, f"{made['finishing_hours']:.2f} h", f"{tv(made):.4f} / {made['ssim']['0.5']:.3f}")


@group
def triangles():
    """docs/relief.md: the six pictures for a ball of 0.5 mm, written whole, as the default, and in 200,000 triangles: as
    milled TV(1), TV(0.5), SSIM(0.5), with megabytes and CPU seconds of the whole command; about six CPU minutes."""
    for picture in ["portrait", "ring", "star", "letter", "spiral", "word"]:
        cells = [picture]
        for flags in ["--fine", "", "--max-triangles 200000"]:
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            said = report(picture, f"--for-cutter ball:0.5 {flags}")
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            milled, took = said["as_milled"], after.ru_utime - before.ru_utime
            figures = f"{tv(milled):.4f}, {tv(milled, '0.5'):.4f}, {milled['ssim']['0.5']:.3f}"
            cells.append(f"{figures} ({megabytes(said):.1f} MB, {took:.1f} CPU s)")
        row(*cells)


@group
def triangles_on_wall():
    """docs/relief.md: a portrait in a room, written whole and as the default: as milled the likeness at the eye's blur, TV(0.5)
    and TV(1), with megabytes; about eight CPU minutes."""
    for flags in ["--fine", ""]:
        said = report("portrait", f"--light 45,0 --lamp-distance 500 --wall 1000 --for-cutter ball:0.5 {flags}")
        milled = said["on_wall"]["as_milled"]
        misplaced = ", ".join(f"{tv(milled, blur):.4f}" for blur in ["0.5deg", "1deg"])
        row(flags, f"{milled['ssim']['eye']:.3f}", misplaced, f"{megabytes(said):.1f} MB")


@group
def coupons():
    """docs/milling.md: test pieces of ten machines, scanned and photographed, and what is read; about ten CPU minutes."""
    for words in [["10"], ["10", "0", "photographs"]]:
        command = ["cargo", "run", "--release", "--locked", "--quiet", "--example", "coupons", "--", *words]
        subprocess.run(command, cwd=ROOT, check=True)


@group
def plans():
    """docs/milling.md: what `plan` finds, expected and proved TV(1), SSIM(0.5); about three CPU minutes each."""
    for picture, machine, flags in [
        ("portrait", "desktop", "--hours 4 --size 100x100"),
        ("portrait", "desktop-good", "--hours 2 --size 30x30"),
        ("portrait", "vmc", "--hours 1 --size 30x30"),
        ("star", "vmc", "--hours 1 --size 30x30"),
        ("star", "vmc-good", "--hours 2 --size 30x30"),
    ]:
        best = report(picture, f"--machine {machine} {flags}", "plan")["best"][0]
        made = best["as_made"]
        way = f"{made['cutter']}, {made['stepover_mm']} mm, {1000 * made['polish_mm']:.0f} um, {best['hours']:.2f} h"
        proved = f"{tv(made):.4f} / {made['ssim']['0.5']:.3f}"
        row(picture, machine, way, f"expected {best['expected_tv_1deg']:.4f}", proved)


@group
def programs():
    """Programs for a machine: lines, CPU seconds of writing and of judging, what is left standing, TV(1) of the program."""
    with tempfile.TemporaryDirectory() as folder:
        drawing = str(PICTURES / "portrait.png")
        design = f"design {drawing} -o plate --cells 1 --for-cutter ball:2 --polish 0.06 --max-triangles 500000 --no-verify"
        making = "mill plate --machine vmc --stepover 0.02 -o shop --no-verify --json"
        check = "mill --check shop/finishing.nc --against plate --polish 0.06 --json"
        said = []
        for words in [design, making, check]:
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            run = subprocess.run([PROGRAM, *words.split()], capture_output=True, text=True, cwd=folder)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            if run.returncode:
                sys.exit(f"{words}\n{run.stderr}")
            said.append((after.ru_utime - before.ru_utime, run.stdout))
        (_, _), (writing, made), (judging, judged) = said
        finishing = next(one for one in json.loads(made)["programs"] if one["part"] == "finishing")
        judged = json.loads(judged)
        row(f"{finishing['lines']} lines", f"{finishing['hours']:.2f} h", f"{finishing['lines_per_second']:.0f} lines/s")
        row(f"written in {writing:.1f} CPU s", f"judged, its light too, in {judging:.1f} CPU s")
        row(f"left standing {judged['surface']['left_mean_um']:.3f} um", f"TV(1) {tv(judged['light']):.4f}")


# Goals of every kind that has no file of its own; steel is Bagher, Soler and Holzschuch's fit of black oxidised steel.
GOALS = ["ward:0.1,0.3", "blinn-phong:40", "ggx:0.2", "shifted-gamma:0.195704,0.706913", "ndf:star"]
OTHER_GOALS = ["phong:20", "gaussian:0.2", "beckmann:0.2", "cook-torrance:0.2", "ward-bounded:0.1,0.3",
               "ashikhmin-shirley:100,20", "lafortune:-0.9,-0.9,1,20"]  # fmt: skip


def goal_rows(specs, flags=""):
    star = ROOT / "examples/highlights/star.png"
    for spec in specs:
        with tempfile.TemporaryDirectory() as folder:
            asked = f"ndf:{star},30" if spec == "ndf:star" else spec
            words = [PROGRAM, "design", "--goal", asked, "-o", f"{folder}/plate", "--json", *flags.split()]
            run = subprocess.run(words, capture_output=True, text=True)
            if run.returncode:
                sys.exit(f"{' '.join(words)}\n{run.stderr}")
            said = json.loads(run.stdout)
        field = said["recipe"]["highlight"]["half-field"]
        row(spec, f"{field}°", *(f"TV(1°) {said[part]['tv']['1']:.4f}" for part in ("designed", "as_milled") if part in said))
        cut = said["goal"].get("as_milled", {}).get("slices", [])
        for k, slice in enumerate(said["goal"]["slices"]):
            row("", f"{slice['theta']:.0f}°, {slice['phi']:.0f}°", f"{slice['tv_1deg']['value']:.4f}",
                f"{slice['mirrors_cannot']:.4f}", f"{slice['rest']['value']:.4f}",
                f"{slice['albedo_goal']:.3f}", f"{slice['albedo_plate']:.3f}",
                *(f"cut {of['tv_1deg']['value']:.4f} {of['rest']['value']:.4f} {of['albedo_plate']:.3f}"
                  for of in cut[k : k + 1]))  # fmt: skip


@group
def goals():
    """Goals: the design's own slice, then lamp, misplaced, by what mirrors cannot follow, by the rest, albedos."""
    goal_rows(GOALS)


@group
def other_goals():
    """The same of the models that are left."""
    goal_rows(OTHER_GOALS)


@group
def goals_cut():
    """The same for a ball of 0.5 mm: behind each lamp's figures misplaced, by the rest and albedo of the plate as cut."""
    goal_rows(["ward:0.1,0.3", "blinn-phong:40", "ggx:0.2"], "--for-cutter ball:0.5 --rays 300000")


# Pictures on 60 x 60 patches of 1 mm unless the flags say otherwise.
PORTRAITS = ["", "--patch-lobe 2", "--viewer 30,180", "--light 0,0 --viewer 0,0",
             "--size 30x30 --patches 30x30 --max-triangles 730000"]  # fmt: skip


@group
def portraits():
    """Portraits: white, contrast, least largest bowl, likeness and TV as written, as cut by a ball of 0.5 mm, CPU seconds."""
    usual = "--size 60x60 --patches 60x60 --light 40,0 --viewer 40,180 --for-cutter ball:0.5 --rays 6000000"
    for flags in PORTRAITS:
        with tempfile.TemporaryDirectory() as folder:
            flagged = dict(zip(*[iter(usual.split() + flags.split())] * 2))
            words = [word for pair in flagged.items() for word in pair]
            picture = ["--portrait", str(PICTURES / "portrait.png"), "-o", f"{folder}/plate", "--json"]
            run = subprocess.run([PROGRAM, "design", *picture, *words], capture_output=True, text=True)
            if run.returncode:
                sys.exit(f"{' '.join(words)}\n{run.stderr}")
            said = json.loads(run.stdout)
        written, cut, reach = said["designed"], said["as_milled"], said["reachable"]
        row(flags or "as it is", f"{reach['white']:.2f}/sr, {reach['contrast']:.0f} to 1",
            f"bowls {said['patches']['most_share'][0]:.2f}", f"{written['ssim']:.3f} {written['tv']:.3f}",
            f"{cut['ssim']:.3f} {cut['tv']:.3f}", f"{said['cpu_seconds']['total']:.0f} CPU s")  # fmt: skip


# Designs as different as they come, and what a dry run is to say of each within a factor of 1.5.
ESTIMATED = [
    ("ring", "--surface facets"),
    ("spiral", "--half-field 45 --facets 30x30 --method weyrich2009"),
    ("ring", ""),
    ("portrait", "--for-cutter ball:0.5 --no-verify"),
    ("portrait", "--for-cutter ball:1"),
    ("ring", "--cells 1 --grid 400 --no-verify"),
    ("ring", "--grid 128 --for-cutter ball:1 --machine vmc --stepover 0.05"),
    ("ring", "--lamp-distance 400 --wall 500 --near base --grid 64"),
    ("ring", "--lamp-distance 400 --wall 500 --near warp --grid 128"),
    ("ring", "--lamp-distance 400 --wall 500 --near exact --grid 64"),
    ("ring", "--lamp-distance 400 --wall 500 --near exact --grid 128 --no-verify"),
    ("ring", "--lamp-distance 400 --wall 500 --near exact --grid 64 --for-cutter ball:1"),
]


@group
def estimates():
    """Dry runs: speed of the machine, CPU seconds told and taken, and how many times as many were told."""
    for picture, flags in ESTIMATED:
        told = report(picture, f"{flags} --dry-run")
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        said = report(picture, flags)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        taken = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        parts = ["design", "verify", "files", *(["comparison"] if said.get("beside_facets") else [])]
        about = sum(told[f"{part}_cpu_seconds_about"] for part in parts)
        row(f"{picture} {flags:78}", f"speed {told['machine_speed']:.2f}", f"{about:.1f}", f"{taken:.1f}", f"{about / taken:.2f}")


def main(names):
    if names == ["--list"]:
        for name, function in GROUPS.items():
            row(f"{name:18}", function.__doc__)
        return
    unknown = [name for name in names if name not in GROUPS]
    if unknown:
        sys.exit(f"no group {unknown[0]}: --list names them")
    for name in names or GROUPS:
        print(f"{name}: {GROUPS[name].__doc__}", flush=True)
        GROUPS[name]()


if __name__ == "__main__":
    main(sys.argv[1:])
