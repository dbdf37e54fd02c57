//! What a surface does with light: dust that scatters evenly, over metal or paint that shines.
//!
//! Reflectance is counted relative to a white Lambertian surface, which has 1 whatever the directions. With unit vectors n
//! (normal), l (to the light), v (to the camera) and h, halfway between l and v, a surface has
//!
//! ```text
//! B = albedo + pi D(n.h) V(n.l, n.v) F(v.h)
//! D(c)    = a^2 / (pi (c^2 (a^2 - 1) + 1)^2)                      Trowbridge and Reitz 1975 ("GGX", Walter et al. 2007), a = roughness
//! V(l, v) = 1/2 / (l sqrt(v^2 (1 - a^2) + a^2) + v sqrt(l^2 (1 - a^2) + a^2))      Smith's masking, height-correlated (Heitz 2014)
//! F(c)    = specular + (1 - specular) (1 - c)^5                                    Schlick 1994
//! ```
//!
//! Left out: colour, polarisation, the light that the microfacets pass on among themselves, and the layering of dust over metal
//! (the two simply add).

/// What a surface looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Share of the light that it scatters evenly in all directions (Lambert): dust, paint, oxide.
    pub albedo: f64,
    /// Share that it mirrors at normal incidence, spread by `roughness`; 0 for a matt surface. Metal some 0.5 to 0.9, paint,
    /// grease and rubber 0.04.
    pub specular: f64,
    /// The microfacets' roughness alpha of the GGX distribution: 0.01 a mirror, 0.5 a dull sheen.
    pub roughness: f64,
    /// Spangle of galvanising: standard deviation of the albedo over the albedo's mean; 0 switches it off.
    pub spangle: f64,
    /// Size of a spangle, in metres.
    pub spangle_m: f64,
    /// Width of the dark seam where sheets of this surface are joined, in metres; 0 for none.
    pub seam_m: f64,
}

impl Look {
    /// A matt surface of this albedo.
    pub const fn matt(albedo: f64) -> Self {
        Self { albedo, specular: 0.0, roughness: 0.3, spangle: 0.0, spangle_m: 0.01, seam_m: 0.0 }
    }

    /// Reflectance B for the cosines of the angles between normal and light, normal and view, normal and halfway, and view and
    /// halfway. Light and camera are on the visible side: `cos_light` and `cos_view` positive.
    pub fn reflectance(&self, cos_light: f64, cos_view: f64, cos_half: f64, cos_view_half: f64) -> f64 {
        if self.specular == 0.0 {
            return self.albedo;
        }
        let a2 = self.roughness * self.roughness;
        let spread = cos_half * cos_half * (a2 - 1.0) + 1.0;
        // pi D
        let distribution = a2 / (spread * spread);
        let masked = |cosine: f64| (cosine * cosine * (1.0 - a2) + a2).sqrt();
        let visible = 0.5 / (cos_light * masked(cos_view) + cos_view * masked(cos_light));
        self.albedo + distribution * visible * self.fresnel(cos_view_half)
    }

    /// Share of the light that is mirrored at this cosine of the angle of incidence.
    pub fn fresnel(&self, cosine: f64) -> f64 {
        let miss = (1.0 - cosine).max(0.0);
        let square = miss * miss;
        self.specular + (1.0 - self.specular) * square * square * miss
    }

    /// The first field out of its bounds, with its value and what it must be.
    pub(crate) fn fault(&self) -> Option<(&'static str, f64, &'static str)> {
        let share = |v: f64| (0.0..=1.0).contains(&v);
        let rules: [(&'static str, f64, bool, &'static str); 6] = [
            ("albedo", self.albedo, share(self.albedo), "from 0 to 1"),
            ("specular", self.specular, share(self.specular), "from 0 to 1"),
            ("roughness", self.roughness, (0.005..=1.0).contains(&self.roughness), "from 0.005 to 1"),
            ("spangle", self.spangle, (0.0..=0.5).contains(&self.spangle), "from 0 to 0.5"),
            ("spangle_m", self.spangle_m, (1e-3..=1.0).contains(&self.spangle_m), "from 0.001 to 1 m"),
            ("seam_m", self.seam_m, (0.0..=0.05).contains(&self.seam_m), "from 0 to 0.05 m"),
        ];
        rules.into_iter().find(|(.., holds, _)| !holds).map(|(field, value, _, bound)| (field, value, bound))
    }
}
