// What all stages that draw light share: the camera, a fragment's ray, surfaces. The equations are in docs/sensor-model.md.

struct Camera {
    // ray of a fragment, before distortion is undone: position * scale + start
    ray_scale: vec2<f32>,
    ray_start: vec2<f32>,
    // clip coordinates of a pixel: (u, v) * scale + start
    clip_scale: vec2<f32>,
    clip_start: vec2<f32>,
    focal_px: vec2<f32>,
    // of the lens that mirrors' lobes are seen through
    focal_mean_px: f32,
    // pixels about the image in the light's image
    margin_px: f32,
    // k1, k2, p1, p2
    distortion: vec4<f32>,
    k3: f32,
    psf_px2: f32,
    // see `Blur` in strip.rs
    defocus_px_m: f32,
    focus_1_m: f32,
    // DN m^2, and factors of daylight and glow; the exposure and the part's share of it are in them
    headlamp: f32,
    daylight: f32,
    glow: f32,
    // share of this part of the exposure in the frame
    share: f32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
// (x, y) of each fragment's ray; not read by a pinhole
@group(0) @binding(1) var rays: texture_2d<f32>;

override DISTORTED: bool = false;
override VIGNETTING: bool = true;
// Whether any surface mirrors.
override SHINY: bool = false;

// The variance of a pixel's side.
const BOX_PX2: f32 = 0.083333333;

// What a 16-bit float can add up without overflow is 65504; nothing drawn is brighter than this, which is far beyond saturation.
const BRIGHTEST: f32 = 15000.0;

struct Corner {
    // (u, v)
    @location(0) pixel: vec2<f32>,
    // 1 / z
    @location(1) inverse_m: f32,
    // which region or strip it is a corner of
    @location(2) item: u32,
}

fn clip_position(corner: Corner) -> vec4<f32> {
    // Depth is 1 mm / z: 1 at the nearest that is drawn, 0 at infinity.
    return vec4(corner.pixel * camera.clip_scale + camera.clip_start, 1e-3 * corner.inverse_m, 1.0);
}

// A fragment's ray, and the derivative of (x, y) by the pixel.
struct PixelRay {
    ray: vec3<f32>,
    per_pixel: mat2x2<f32>,
}

fn pixel_ray(position: vec4<f32>) -> PixelRay {
    if !DISTORTED {
        let ray = vec3(position.xy * camera.ray_scale + camera.ray_start, 1.0);
        return PixelRay(ray, mat2x2(camera.ray_scale.x, 0.0, 0.0, camera.ray_scale.y));
    }
    let at = textureLoad(rays, vec2<i32>(position.xy), 0).xy;
    // The derivative of the distorted ray by the ray (lens.rs), inverted.
    let r2 = dot(at, at);
    let k = camera.distortion;
    let radial = 1.0 + r2 * (k.x + r2 * (k.y + r2 * camera.k3));
    let bend = k.x + r2 * (2.0 * k.y + r2 * 3.0 * camera.k3);
    let mixed = 2.0 * at.x * at.y * bend + 2.0 * k.z * at.x + 2.0 * k.w * at.y;
    let xx = radial + 2.0 * at.x * at.x * bend + 2.0 * k.z * at.y + 6.0 * k.w * at.x;
    let yy = radial + 2.0 * at.y * at.y * bend + 6.0 * k.z * at.y + 2.0 * k.w * at.x;
    let inverse = 1.0 / (xx * yy - mixed * mixed);
    // d(x, y) / d(u, v): columns are the derivatives by u and by v.
    let by_u = vec2(yy, -mixed) * (inverse / camera.focal_px.x);
    let by_v = vec2(-mixed, xx) * (inverse / camera.focal_px.y);
    return PixelRay(vec3(at, 1.0), mat2x2(by_u, by_v));
}

// Share of the light that the lens passes along a ray.
fn falloff(ray: vec3<f32>) -> f32 {
    let square = 1.0 / dot(ray, ray);
    return select(1.0, square * square, VIGNETTING);
}

// Variance of lens and defocus for what is seen at z = 1 / inverse_z, in px^2.
fn lens_px2(inverse_z: f32) -> f32 {
    let defocus = camera.defocus_px_m * (inverse_z - camera.focus_1_m);
    return camera.psf_px2 + defocus * defocus;
}

// Standard normal distribution function, to 1e-6: a minimax fit to Phi(z) - 1/2 by z P(z^2) / Q(z^2) for |z| < 5.2.
fn phi(z: f32) -> f32 {
    let c = clamp(z, -5.2, 5.2);
    let x = c * c;
    let p = 0.39894670 + x * (0.019476926 + x * (0.0034026804 + x * (-3.9751074e-5 + x * -7.2454259e-7)));
    let q = 1.0 + x * (0.21554130 + x * (0.019378820 + x * (7.6526520e-4 + x * -2.3996046e-5)));
    return 0.5 + c * p / q;
}

// Schlick's approximation.
fn fresnel(specular: f32, cosine: f32) -> f32 {
    let miss = max(1.0 - cosine, 0.0);
    let square = miss * miss;
    return specular + (1.0 - specular) * square * square * miss;
}

// B of surface.rs; look is (albedo, specular, roughness).
fn reflectance(look: vec3<f32>, cos_light: f32, cos_view: f32, cos_half: f32, cos_view_half: f32) -> f32 {
    if !SHINY {
        return look.x;
    }
    let a2 = look.z * look.z;
    // c^2 (a^2 - 1) + 1 loses its digits in single precision where the lobe is narrow.
    let spread = cos_half * cos_half * a2 + max(1.0 - cos_half * cos_half, 0.0);
    let distribution = a2 / (spread * spread);
    let visible = 0.5 / (cos_light * sqrt(cos_view * cos_view * (1.0 - a2) + a2) + cos_view * sqrt(cos_light * cos_light * (1.0 - a2) + a2));
    return look.x + select(0.0, distribution * visible * fresnel(look.y, cos_view_half), look.y > 0.0);
}
