//! Command lines of the program's own flags, drawn at random.

use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::words;

/// Values that are ordinary, and others at and beyond every edge.
const NUMBERS: [&str; 24] = [
    "1",
    "2",
    "3",
    "16",
    "30",
    "0.5",
    "12.5",
    "0",
    "-1",
    "-0",
    "nan",
    "inf",
    "-inf",
    "1e308",
    "1e-308",
    "1e-9",
    "1e9",
    "4096",
    "4097",
    "65536",
    "4294967296",
    "18446744073709551616",
    "9.2e18",
    "",
];

/// Flags of each command and what they take: numbers are drawn for #.
const DESIGN: [&str; 39] = [
    "--half-field #",
    "--projection screen",
    "--projection equidistant",
    "--quantity flux",
    "--light #,#",
    "--light-radius #",
    "--seen on-wall",
    "--rotate #",
    "--invert",
    "--fit crop",
    "--fit stretch",
    "--linear",
    "--srgb",
    "--size #x#",
    "--thickness #",
    "--border #",
    "--border-finish polished",
    "--border-finish sloped:#",
    "--lobe #",
    "--surface facets",
    "--surface sheet",
    "--cells #",
    "--grid #",
    "--max-triangles #",
    "--for-cutter ball:#",
    "--for-cutter ball-1",
    "--flutes #",
    "--worn-tip #",
    "--min-feature #",
    "--polish #",
    "--max-depth #",
    "--facets #x#",
    "--sample sobol",
    "--sample random",
    "--arrange random",
    "--heights cyclic",
    "--level",
    "--slope-cap #",
    "--method weyrich2009",
];
/// A lamp and a wall at a distance.
const ROOM: [&str; 11] = [
    "--lamp-distance #",
    "--lamp-at #,#,#",
    "--lamp-radius #",
    "--wall #",
    "--wall-tilt #",
    "--picture-width #",
    "--focus #",
    "--near base",
    "--near warp",
    "--near exact",
    "--eye-distance #",
];
/// The plate as a machine makes it.
const MACHINE: [&str; 10] = [
    "--machine desktop",
    "--machine vmc",
    "--stepover #",
    "--pass-angle #",
    "--one-way",
    "--zigzag",
    "--draws #",
    "--polish #",
    "--for-cutter ball:#",
    "--worn",
];
const MILL: [&str; 20] = [
    "--machine vmc",
    "--dialect grbl",
    "--dialect linuxcnc",
    "--dialect mach3",
    "--compensate",
    "--spindle #",
    "--cutter ball:#",
    "--cutter bull:#,#",
    "--cutter flat:#",
    "--cutter cone:#,#",
    "--cutter tapered:#,#",
    "--cutter ball-1",
    "--worn",
    "--stepover #",
    "--pass-angle #",
    "--zigzag",
    "--polish #",
    "--material brass",
    "--stock-over #",
    "--rough-cutter flat:#",
];
/// Models of reflectance in place of a picture.
const GOALS: [&str; 12] = [
    "ward:#,#",
    "blinn-phong:#",
    "ggx:#,#,#",
    "beckmann:#",
    "phong:#",
    "lambert:#",
    "shifted-gamma:#",
    "gaussian:#",
    "ashikhmin-shirley:#,#",
    "oren-nayar:#",
    "ndf:ring.png",
    "mirror",
];
const MEASURE: [&str; 26] = [
    "--brdf",
    "--ndf",
    "--wall #",
    "--look",
    "--material aluminium:ggx:#",
    "--material paint:#",
    "--material gold@#",
    "--margin #",
    "--extent endless",
    "--lamp ring.png",
    "--lamp-half-field #",
    "--resolution #",
    "--polar #",
    "--azimuths #",
    "--half-vectors #x#",
    "--lamp-distance #",
    "--lamp-radius #",
    "--wall-tilt #",
    "--wall-width #",
    "--camera #,#",
    "--distance #",
    "--field #",
    "--wrap sphere:#",
    "--ambient #",
    "--light #,#",
    "--light-radius #",
];
const RUNNING: [&str; 9] = [
    "--threads #",
    "--memory #G",
    "--memory #M",
    "--seed #",
    "--quiet",
    "--json",
    "--dry-run",
    "--no-verify",
    "--max-bounces #",
];

/// One of `flags`, with numbers for its #.
fn filled(flags: &[&str], rng: &mut Xoshiro256PlusPlus) -> String {
    let flag = flags[rng.random_range(0..flags.len())];
    let mut parts = flag.split('#');
    let mut whole = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        // Mostly what makes sense, else nothing would ever be done.
        let reach = if rng.random_bool(0.7) { 7 } else { NUMBERS.len() };
        whole += NUMBERS[rng.random_range(0..reach)];
        whole += part;
    }
    whole
}

/// A command line of the program's own flags.
pub fn drawn(rng: &mut Xoshiro256PlusPlus) -> Vec<String> {
    // Small ones: what the default plate takes is no news.
    let (start, flags): (&str, &[&str]) = match rng.random_range(0..11) {
        0 => ("design ring.png -o d --force", &DESIGN),
        1 => ("design ring.png -o d --force --facets 6x6 --rays 2000", &DESIGN),
        2 => ("design ring.png -o d --force --surface sheet --size 10x10 --grid 16 --cells 1 --no-verify", &DESIGN),
        3 => ("measure plate -o m --force --rays 1000 --resolution 16", &MEASURE),
        4 => ("measure plate -o m --force --rays 1000 --brdf --polar 2 --half-vectors 16x8", &MEASURE),
        5 | 6 => ("verify plate/plate.stl --against ring.png -o v --force --rays 2000", &DESIGN[..13]),
        7 => ("design ring.png -o d --force --surface sheet --size 10x10 --grid 16 --cells 1 --rays 2000", &ROOM),
        8 => ("verify plate/plate.stl --against ring.png -o v --force --rays 2000", &MACHINE),
        9 => ("mill plate --machine desktop -o g --force", &MILL),
        _ => ("design -o d --force --surface sheet --size 10x10 --grid 16 --cells 1 --rays 2000", &DESIGN[4..15]),
    };
    let mut line = words(start);
    if line.len() == 5 && line[0] == "design" {
        line.push("--dry-run".into());
    }
    if line[1] == "-o" {
        line.extend(["--goal".into(), filled(&GOALS, rng)]);
    }
    let mut add = |flags: &[&str], rng: &mut Xoshiro256PlusPlus| {
        let whole = filled(flags, rng);
        let (name, value) = whole.split_once(' ').map_or((&*whole, None), |(name, value)| (name, Some(value)));
        line.push(name.into());
        line.extend(value.map(Into::into));
    };
    for _ in 0..rng.random_range(0..5) {
        add(flags, rng);
    }
    if rng.random_bool(0.5) {
        add(&RUNNING, rng);
    }
    line
}
