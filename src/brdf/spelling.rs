//! The textual form of a [`Material`]: SUBSTANCE[@NM][:NUMBERS][:ggx|beckmann:ALPHA[,ALPHA_Y]].

use std::fmt;
use std::str::{FromStr, Split};

use super::material::{Material, MaterialError, Substance};
use super::metals::Metal;
use super::microfacet::{Lobe, MicrofacetDistribution};
use super::model::named::{Named, names};

impl Material {
    /// What a material may be written as, for help texts and error messages.
    pub fn known() -> String {
        let metals: Vec<_> = Metal::ALL.into_iter().map(Metal::name).collect();
        format!(
            "mirror, {}, acrylic, dielectric:ETA, conductor:ETA,K, paint:ALBEDO, diffuse:ALBEDO, \
             each but the last also with :ggx:ALPHA or :beckmann:ALPHA; and the models {}",
            metals.join(", "),
            names()
        )
    }
}

impl FromStr for Material {
    type Err = MaterialError;

    fn from_str(text: &str) -> Result<Self, MaterialError> {
        if Named::begins(text) || text.contains('+') {
            return Self::new(Substance::Model(text.parse()?), None);
        }
        let mut parts = text.trim().split(':');
        let substance = substance(&mut parts)?;
        let lobe = parts.next().map(|law| lobe(law, parts.next())).transpose()?;
        if let Some(rest) = parts.next() {
            return Err(MaterialError::TooMuch(rest.to_owned()));
        }
        Self::new(substance, lobe)
    }
}

fn substance(parts: &mut Split<'_, char>) -> Result<Substance, MaterialError> {
    let word = parts.next().unwrap_or_default();
    let numbers = |parts: &mut Split<'_, char>, takes: &'static str, example: &'static str, allowed: &[usize]| {
        let text = parts.next().unwrap_or_default();
        let numbers = if text.is_empty() { Vec::new() } else { numbers(text)? };
        if allowed.contains(&numbers.len()) {
            return Ok(numbers);
        }
        Err(MaterialError::Numbers { word: word.to_owned(), takes, example })
    };
    Ok(match word {
        "mirror" => Substance::Mirror,
        "acrylic" => Substance::Dielectric { eta: Substance::ACRYLIC },
        "dielectric" => {
            let n = numbers(parts, "an index of refraction", "dielectric:1.5", &[1])?;
            Substance::Dielectric { eta: n[0] }
        }
        "conductor" => {
            let n = numbers(parts, "an index of refraction and an absorption", "conductor:1.2,6.9", &[2])?;
            Substance::Conductor { eta: n[0], k: n[1] }
        }
        "paint" => {
            let takes = "an albedo and, if wanted, the coat's index of refraction";
            let n = numbers(parts, takes, "paint:0.8 or paint:0.8,1.5", &[1, 2])?;
            Substance::Paint { albedo: n[0], eta: n.get(1).copied().unwrap_or(Substance::BINDER) }
        }
        "diffuse" => {
            let n = numbers(parts, "an albedo", "diffuse:0.5", &[1])?;
            Substance::Diffuse { albedo: n[0] }
        }
        _ => {
            let (name, wavelength) = match word.split_once('@') {
                Some((name, wavelength)) => (name, Some(wavelength)),
                None => (word, None),
            };
            let metal = Metal::named(name).ok_or_else(|| MaterialError::Unknown(word.to_owned()))?;
            Substance::Metal(metal, wavelength.map_or(Ok(Substance::WAVELENGTH), number)?)
        }
    })
}

fn lobe(law: &str, alphas: Option<&str>) -> Result<Lobe, MaterialError> {
    let distribution =
        MicrofacetDistribution::named(law).ok_or_else(|| MaterialError::MicrofacetDistribution(law.to_owned()))?;
    let alphas = alphas.filter(|text| !text.is_empty()).map(numbers).transpose()?.unwrap_or_default();
    match alphas[..] {
        [alpha] => Ok(Lobe::new(distribution, alpha, alpha)?),
        [x, y] => Ok(Lobe::new(distribution, x, y)?),
        _ => Err(MaterialError::Numbers {
            word: law.to_owned(),
            takes: "one roughness, or two for along x and along y",
            example: "brass:ggx:0.2 or brass:ggx:0.1,0.3",
        }),
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, MaterialError> {
    text.split(',').map(number).collect()
}

fn number(text: &str) -> Result<f64, MaterialError> {
    text.trim().parse().map_err(|_| MaterialError::NotANumber(text.to_owned()))
}

impl fmt::Display for Material {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self.substance() {
            Substance::Model(ref model) => write!(f, "{model}")?,
            Substance::Mirror => write!(f, "mirror")?,
            Substance::Metal(metal, nm) if nm == Substance::WAVELENGTH => write!(f, "{}", metal.name())?,
            Substance::Metal(metal, nm) => write!(f, "{}@{nm}", metal.name())?,
            Substance::Conductor { eta, k } => write!(f, "conductor:{eta},{k}")?,
            Substance::Dielectric { eta } if eta == Substance::ACRYLIC => write!(f, "acrylic")?,
            Substance::Dielectric { eta } => write!(f, "dielectric:{eta}")?,
            Substance::Paint { albedo, eta } if eta == Substance::BINDER => write!(f, "paint:{albedo}")?,
            Substance::Paint { albedo, eta } => write!(f, "paint:{albedo},{eta}")?,
            Substance::Diffuse { albedo } => write!(f, "diffuse:{albedo}")?,
        }
        self.lobe().map_or(Ok(()), |lobe| write!(f, ":{lobe}"))
    }
}

impl TryFrom<String> for Material {
    type Error = MaterialError;

    fn try_from(text: String) -> Result<Self, MaterialError> {
        text.parse()
    }
}

impl From<Material> for String {
    fn from(material: Material) -> Self {
        material.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_comes_back() {
        for text in [
            "mirror",
            "mirror:ggx:0.2",
            "aluminium",
            "brass:ggx:0.2",
            "gold@650:beckmann:0.1,0.3",
            "acrylic",
            "acrylic:ggx:0.05",
            "dielectric:1.6",
            "conductor:1.2,6.9:ggx:0.1",
            "paint:0.8",
            "paint:0.8:ggx:0.3",
            "paint:0.8,1.6:beckmann:0.3",
            "diffuse:0.5",
            "conductor:0.1234567890123,6.9",
            "ward:0.1,0.3:0.6",
            "ggx:0.2,0.05,30",
            "lambert:0.3+shifted-gamma:0.196,0.707:schlick=0.08",
            "lafortune:-0.5,-0.5,0.45,20/-0.2,-0.2,0.2,5",
        ] {
            let material: Material = text.parse().unwrap();
            assert_eq!(material.to_string(), text);
            let json = serde_json::to_string(&material).unwrap();
            assert_eq!(json, format!("\"{text}\""));
            assert_eq!(serde_json::from_str::<Material>(&json).unwrap(), material);
        }
        assert_eq!("aluminum".parse::<Material>().unwrap().to_string(), "aluminium");
        assert_eq!(" brass:ggx:.2,.2 ".parse::<Material>().unwrap().to_string(), "brass:ggx:0.2");
    }

    #[test]
    fn a_wrong_text_is_told_what_would_do() {
        for (text, part) in [
            ("", "'' is not a material; known are mirror, aluminium"),
            ("bras", "'bras' is not a material"),
            ("bras@600", "'bras@600' is not a material"),
            ("Brass", "'Brass' is not a material"),
            ("brass@", "'' in a material is not a number"),
            ("brass@380", "wavelength in nm must be 400 to 750, not 380"),
            ("brass:phong:3", "'phong' is not a kind of roughness; use ggx or beckmann"),
            ("brass:0.2", "'0.2' is not a kind of roughness"),
            ("brass:ggx", "'ggx' takes one roughness"),
            ("brass:ggx:", "'ggx' takes one roughness"),
            ("brass:ggx:1,2,3", "'ggx' takes one roughness"),
            ("brass:ggx:x", "'x' in a material is not a number"),
            ("brass:ggx:0", "a roughness of 0 is outside 0.001 to 2"),
            ("brass:ggx:NaN", "a roughness of NaN is outside"),
            ("brass:ggx:0.2:0.3", "'0.3' is one part too many"),
            ("conductor:1.2", "'conductor' takes an index of refraction and an absorption, as in conductor:1.2,6.9"),
            ("conductor:0,1", "index of refraction must be 0.001 to 100, not 0"),
            ("conductor:1,-1", "absorption k must be 0 to 100, not -1"),
            ("dielectric", "'dielectric' takes an index of refraction"),
            ("dielectric:0.9", "index of refraction must be 1 to 5, not 0.9"),
            ("paint", "'paint' takes an albedo"),
            ("paint:1.1", "albedo must be 0 to 1, not 1.1"),
            ("diffuse:inf", "albedo must be 0 to 1, not inf"),
            ("diffuse:0.5:ggx:0.1", "diffuse has no mirror facets"),
            ("ward", "'ward' takes roughness along x, roughness along y, turn in degrees, as in ward:0.2 or"),
            ("ward:3", "roughness along x of 'ward' must be 0.001 to 2, not 3"),
            ("lambert:0.2+bras", "'bras' is not a model of reflectance; known are lambert, oren-nayar"),
            ("ggx:0.2:f=1", "'f=' is no kind of share"),
            ("ggx:0.2:0.5:1", "'1' is one part too many in a model"),
            ("ggx:0.2/0.3", "'0.2/0.3' in a model is not a number"),
            ("lafortune:1,2,3", "'lafortune' takes Cx, Cy, Cz, exponent, as in"),
            ("lambert:0.8+phong:5", "sends back 1."),
        ] {
            let message = text.parse::<Material>().unwrap_err().to_string();
            assert!(message.contains(part), "{text}: {message}");
        }
    }
}
