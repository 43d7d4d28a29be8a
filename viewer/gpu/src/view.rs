//! The uniform buffer of a picture, which all shaders of the fleet share: camera, lights and
//! colours.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, UVec2, Vec2, Vec3, Vec4};
use regatta_scene::camera::Camera;
use regatta_scene::palette::{Colouring, Legend, Rgb, Scale, Theme};
use regatta_scene::{Detail, MAX_LIGHTS, Scene};

/// The shaders' `View`; view.wgsl documents the fields.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ViewUniform {
    pub clip_from_local: Mat4,
    pub eye: Vec4,
    pub forward: Vec4,
    pub right: Vec4,
    pub up: Vec4,
    pub planes: [Vec4; 4],
    pub viewport: Vec4,
    pub crop: Vec4,
    pub origin: Vec4,
    pub alpha: f32,
    pub teleport_distance: f32,
    pub robots: u32,
    pub previous_robots: u32,
    pub source: u32,
    pub low: f32,
    pub per_span: f32,
    pub categories: u32,
    pub unknown: Vec4,
    pub detail: Vec4,
    pub sun: Vec4,
    pub sun_colour: Vec4,
    pub ambient_above: Vec4,
    pub ambient_below: Vec4,
    pub sky: Vec4,
    pub floor: Vec4,
    pub grid: Vec4,
    pub spacing: Vec4,
    pub floor_bounds: Vec4,
    pub edge: Vec4,
    pub two_way: Vec4,
    pub node: Vec4,
    pub selection: Vec4,
    pub route: Vec4,
    pub waiting: Vec4,
    pub ring: Vec4,
    pub wall: Vec4,
    pub rack: Vec4,
    pub density: Vec4,
    pub filtered: u32,
    pub heated: u32,
    pub reserved: [u32; 2],
    pub palette: [u32; SHADES],
    pub lights: [[Vec4; 2]; MAX_LIGHTS],
}

/// The number of colours in the palette; the steps between two colours of a ramp. The same as in
/// poses.wgsl.
const SHADES: usize = 64;
const STEPS: usize = 4;
/// Direction towards the sun, not normalized.
const SUN: Vec3 = Vec3::new(-0.45, -0.35, 0.85);
/// The least distance between two lines of the grid, in pixels.
const GRID_PIXELS: f32 = 9.0;

impl ViewUniform {
    /// Returns the uniforms of a picture of `size` pixels. The renderer adds the numbers of robots
    /// and values, `alpha` and `teleport_distance`.
    pub fn new(camera: &Camera, scene: &Scene, legend: &Legend, size: UVec2) -> Self {
        let mut view = Self::zeroed();
        view.set_camera(camera, scene, size.as_vec2());
        view.set_lights(camera, scene);
        view.set_colours(scene, legend);
        view
    }

    /// The least and the greatest distance along the view direction of ground in the picture, in
    /// metres; infinity where there is none.
    pub fn ground_distances(&self) -> (f32, f32) {
        let (right, up) = (self.right.truncate() * self.right.w, self.up.truncate() * self.up.w);
        let (mut near, mut far) = (f32::INFINITY, 0.0_f32);
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let ray = self.forward.truncate() + right * x + up * y;
            let distance = if ray.z < 0.0 { self.eye.z / -ray.z } else { f32::INFINITY };
            (near, far) = (near.min(distance), far.max(distance));
        }
        (near, far)
    }

    fn set_camera(&mut self, camera: &Camera, scene: &Scene, size: Vec2) {
        // Whole metres: subtracting them from positions loses no precision.
        let origin = camera.target.truncate().round();
        let eye = camera.eye() - origin.extend(0.0);
        let (forward, right, up) = (camera.forward(), camera.right(), camera.up());
        let tan_y = (camera.fov_y / 2.0).tan();
        let tan_x = tan_y * size.x / size.y;
        let pixels_per_radian = camera.pixels_per_radian(size.y);
        self.clip_from_local = camera.clip_from(origin.extend(0.0), size.x / size.y);
        self.eye = eye.extend(pixels_per_radian);
        self.forward = forward.extend(0.0);
        self.right = right.extend(tan_x);
        self.up = up.extend(tan_y);
        self.planes = [(right, tan_x), (-right, tan_x), (up, tan_y), (-up, tan_y)]
            .map(|(side, tan)| (side + forward * tan).normalize().extend(0.0));
        self.viewport = Vec4::new(size.x, size.y, 1.0 / size.x, 1.0 / size.y);
        self.crop = Vec4::new(1.0, 1.0, 0.0, 0.0);
        let fleet_origin = origin - scene.offset;
        self.origin = Vec4::new(fleet_origin.x, fleet_origin.y, origin.x, origin.y);
        // A plan has footprints: blocks seen from above, at their true size as far as pixels allow.
        let detail = if camera.is_plan() {
            Detail { mesh: f32::MAX, block: 1.0, mark: 2.0, ..scene.detail }
        } else {
            scene.detail
        };
        self.detail = Vec4::new(detail.mesh, detail.block, detail.mark, 0.0);
        let metres_per_pixel = camera.distance / pixels_per_radian;
        let spacing = 10_f32.powf((metres_per_pixel * GRID_PIXELS).log10().ceil()).max(1.0);
        self.spacing = Vec4::new(
            spacing,
            metres_per_pixel,
            scene.lights.len().min(MAX_LIGHTS) as f32,
            scene.detail.thin,
        );
        let unbounded = Vec4::new(-1e9, -1e9, 1e9, 1e9);
        self.floor_bounds = scene.floor.bounds.map_or(unbounded, |bounds| {
            let (low, high) = (bounds.low - origin, bounds.high - origin);
            Vec4::new(low.x, low.y, high.x, high.y)
        });
    }

    fn set_lights(&mut self, camera: &Camera, scene: &Scene) {
        let dark = scene.theme == Theme::Dark;
        self.sun = SUN.normalize().extend(if dark { 0.65 } else { 0.42 });
        let (sun, above, below) = if dark { (0.75, 0.42, 0.16) } else { (0.72, 0.48, 0.30) };
        self.sun_colour = Vec4::new(1.0, 0.97, 0.92, 0.0) * sun;
        self.ambient_above = Vec4::new(0.95, 0.98, 1.0, 0.0) * above;
        self.ambient_below = Vec4::new(1.0, 0.98, 0.95, 0.0) * below;
        let origin = camera.target.truncate().round().extend(0.0);
        for (uniform, light) in self.lights.iter_mut().zip(&scene.lights) {
            *uniform = [(light.position - origin).extend(0.0), light.colour.extend(0.0)];
        }
    }

    fn set_colours(&mut self, scene: &Scene, legend: &Legend) {
        let colours = scene.theme.colours();
        self.sky = solid(colours.sky);
        self.floor = solid(colours.floor);
        self.grid = colours.grid.linear().extend(if scene.layers.grid { 1.0 } else { 0.0 });
        self.edge = solid(colours.edge);
        self.two_way = solid(colours.two_way);
        self.node = solid(colours.node);
        self.selection = solid(colours.selection);
        self.route = solid(colours.route);
        self.waiting = solid(colours.waiting);
        self.ring = solid(colours.ring);
        self.wall = solid(colours.wall);
        self.rack = solid(colours.rack);
        self.unknown = solid(colours.unknown);
        self.palette = palette(&legend.scale, scene.theme);
        self.source = match scene.colouring {
            Colouring::State => 1,
            Colouring::Type => 2,
            Colouring::Speed | Colouring::Column(_) => 0,
        };
        (self.low, self.per_span, self.categories) = match &legend.scale {
            Scale::Categories(names) => (0.0, 1.0 / names.len().saturating_sub(1).max(1) as f32, 1),
            Scale::Ramp { low, high, .. } => (*low, 1.0 / (high - low).max(1e-6), 0),
        };
    }
}

fn solid(colour: Rgb) -> Vec4 {
    colour.linear().extend(1.0)
}

/// Returns the colours of categories by index, or a ramp, as linear red, green and blue of 8 bits
/// each.
fn palette(scale: &Scale, theme: Theme) -> [u32; SHADES] {
    let colours = scale.colours(theme).map(Rgb::linear);
    let last = colours.len() - 1;
    std::array::from_fn(|shade| {
        let colour = match scale {
            Scale::Categories(_) => colours[shade.min(last)],
            Scale::Ramp { .. } => {
                let below = (shade / STEPS).min(last);
                colours[below]
                    .lerp(colours[(below + 1).min(last)], (shade % STEPS) as f32 / STEPS as f32)
            }
        };
        let [red, green, blue] = (colour * 255.0).round().as_uvec3().to_array();
        red | green << 8 | blue << 16
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_ground_is_at_the_lower_border_of_the_picture_and_the_farthest_at_the_upper_one()
    {
        let (scene, size) = (Scene::default(), UVec2::new(320, 200));
        let legend = Colouring::State.legend(Theme::Dark, &[], None);
        let distances = |pitch| {
            let camera = Camera { pitch, distance: 100.0, ..Camera::default() };
            (camera, ViewUniform::new(&camera, &scene, &legend, size).ground_distances())
        };
        let (camera, (near, far)) = distances(std::f32::consts::FRAC_PI_2);
        let height = camera.eye().z;
        assert!(
            (near - height).abs() < 0.1 && (far - height).abs() < 0.1,
            "everywhere the same from above: {near} {far}"
        );
        let (camera, (flat, horizon)) = distances(0.4);
        assert!(horizon > 2.0 * flat, "{horizon}");
        let lower = camera.unproject(Vec2::new(160.0, 200.0), size.as_vec2()).expect("ground");
        let depth = (lower.extend(0.0) - camera.eye()).dot(camera.forward());
        assert!((flat - depth).abs() < 0.1 && flat < 90.0, "{flat} instead of {depth}");
    }
}
