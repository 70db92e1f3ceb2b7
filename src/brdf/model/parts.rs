//! Models changed and added: turned about the normal, weakened by a share or by Fresnel's, summed.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::Model;
use crate::brdf::fresnel::{dielectric, schlick};

/// A model turned counter-clockwise about the normal.
pub struct Turned<M> {
    /// As it was.
    pub model: M,
    /// Cosine and sine of the turn.
    pub turn: DVec2,
}

impl<M> Turned<M> {
    /// `model` turned by `angle` radians.
    pub fn new(model: M, angle: f64) -> Self {
        Self { model, turn: DVec2::from_angle(angle) }
    }

    fn back(&self, w: DVec3) -> DVec3 {
        let turn = DVec2::new(self.turn.x, -self.turn.y);
        turn.rotate(w.truncate()).extend(w.z)
    }
}

impl<M: Model> Model for Turned<M> {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.model.value(self.back(wi), self.back(wo))
    }

    fn sample(&self, wi: DVec3, u: [f64; 3]) -> DVec3 {
        let wo = self.model.sample(self.back(wi), u);
        self.turn.rotate(wo.truncate()).extend(wo.z)
    }

    fn density(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.model.density(self.back(wi), self.back(wo))
    }

    fn albedo(&self, wi: DVec3) -> f64 {
        self.model.albedo(self.back(wi))
    }
}

/// Which share a lobe reflects of what it would.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Share {
    /// The same at every angle.
    Even(f64),
    /// Schlick's Fresnel, from its value straight on.
    Schlick(f64),
    /// Fresnel's of a dielectric, from its index of refraction.
    Index(f64),
}

impl Share {
    /// At an angle of light to the half vector.
    pub fn at(self, cosine: f64) -> f64 {
        match self {
            Self::Even(share) => share,
            Self::Schlick(straight_on) => schlick(cosine, straight_on),
            Self::Index(eta) => dielectric(cosine, eta),
        }
    }
}

/// A model times a [`Share`].
pub struct Weakened<M> {
    /// As it was.
    pub model: M,
    /// Of which so much is left.
    pub share: Share,
}

impl<M: Model> Model for Weakened<M> {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        let cosine = wi.dot((wi + wo).normalize_or(DVec3::Z));
        self.share.at(cosine) * self.model.value(wi, wo)
    }

    fn sample(&self, wi: DVec3, u: [f64; 3]) -> DVec3 {
        self.model.sample(wi, u)
    }

    fn density(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.model.density(wi, wo)
    }

    fn albedo(&self, wi: DVec3) -> f64 {
        match self.share {
            Share::Even(share) => share * self.model.albedo(wi),
            _ => super::albedo_by_quadrature(self, wi),
        }
    }
}

/// Models added; each is sampled as often as the others.
#[derive(Clone)]
pub struct Sum(pub Vec<Arc<dyn Model>>);

impl Model for Sum {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.0.iter().map(|model| model.value(wi, wo)).sum()
    }

    fn sample(&self, wi: DVec3, u: [f64; 3]) -> DVec3 {
        let at = u[2] * self.0.len() as f64;
        match self.0.get((at as usize).min(self.0.len().saturating_sub(1))) {
            Some(model) => model.sample(wi, [u[0], u[1], at.fract()]),
            None => -DVec3::Z,
        }
    }

    fn density(&self, wi: DVec3, wo: DVec3) -> f64 {
        let sum: f64 = self.0.iter().map(|model| model.density(wi, wo)).sum();
        sum / self.0.len().max(1) as f64
    }

    fn albedo(&self, wi: DVec3) -> f64 {
        self.0.iter().map(|model| model.albedo(wi)).sum()
    }
}

impl<M: Model + ?Sized> Model for Arc<M> {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        (**self).value(wi, wo)
    }

    fn sample(&self, wi: DVec3, u: [f64; 3]) -> DVec3 {
        (**self).sample(wi, u)
    }

    fn density(&self, wi: DVec3, wo: DVec3) -> f64 {
        (**self).density(wi, wo)
    }

    fn albedo(&self, wi: DVec3) -> f64 {
        (**self).albedo(wi)
    }
}
