//! Whether the camera can be where the poses of a study put it: known before anything is rendered.

use ductloop_sensor::frame_geometry::clear_cell;
use ductloop_sensor::renderer::RenderError;
use ductloop_sensor::scenery::Scenery;

use super::pose::Pose;
use super::trial::TrialError;
use crate::closed_loop::RunError;
use crate::scenario::Scenario;
use crate::scenario::accuracy_file::AccuracyFile;
use crate::viewpoint::world_from_camera;

/// Makes sure that the camera stands inside the duct, off its metal, in every pose of every cell.
///
/// # Errors
/// The first pose, in order, in which it does not.
pub fn all_stand(file: &AccuracyFile) -> Result<(), Box<TrialError>> {
    for (cell, scenario) in file.cells.iter().map(|cell| &cell.scenario).enumerate() {
        let mut room: Option<Room> = None;
        for index in 0..file.poses.count {
            let pose = Pose::draw(scenario, &file.poses, scenario.seed, index);
            let mut stands = || -> Result<Room, RunError> {
                let here = match room.take().filter(|room| room.width_m == pose.width_m) {
                    Some(room) => room,
                    None => Room::of(scenario, pose.width_m)?,
                };
                here.holds(scenario, &pose)?;
                Ok(here)
            };
            room = Some(stands().map_err(|error| Box::new(TrialError { cell, index, pose, error }))?);
        }
    }
    Ok(())
}

/// A duct of one width: most poses of a study may share it.
struct Room {
    width_m: f64,
    network: ductloop_duct::network::Network,
    scenery: Scenery,
}

impl Room {
    fn of(scenario: &Scenario, width_m: f64) -> Result<Self, RunError> {
        let mut duct = scenario.duct.clone();
        duct.width_m = width_m;
        let looks: Vec<_> = scenario.surfaces.iter().map(|surface| surface.look).collect();
        let network = duct.network()?;
        let scenery = Scenery::new(&network, &looks)?;
        Ok(Self { width_m, network, scenery })
    }

    /// As a renderer judges it.
    fn holds(&self, scenario: &Scenario, pose: &Pose) -> Result<(), RunError> {
        let base = pose.world_from_base(&self.network.centreline);
        let camera = world_from_camera(&scenario.actual_rig(), &base, scenario.rig.mount.rest, Default::default());
        clear_cell(&self.scenery, &camera.translation.vector.into(), self.network.cells.len() / 2)
            .map_err(|obstacle| RenderError::standpoint(obstacle, &camera))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::trial::trial;

    const FILE: &str = "format = 1\nkind = \"accuracy\"\nname = \"x\"\n[poses]\ncount = 12\nlateral_m = [-0.3, 0.3]\n[duct]\n\
                        width_m = 0.5\nheight_m = 0.3\nrun = [{ straight_m = 8.0 }]\n[start]\ndistance_m = 3.0\n";

    /// What is refused beforehand is what could not be rendered, and nothing else.
    #[test]
    fn poses_are_judged_as_the_renderer_does() {
        let file = AccuracyFile::from_toml_str(FILE).unwrap();
        let told = all_stand(&file).unwrap_err();
        let rendered = (0..told.index + 1).map(|index| trial(&file.cells[0].scenario, 0, &file.poses, index, &[]));
        let failed: Vec<_> = rendered.filter_map(Result::err).collect();
        assert_eq!(failed.len(), 1);
        assert_eq!((failed[0].index, failed[0].to_string()), (told.index, told.to_string()));
        assert!(told.to_string().contains("lateral offset") && !told.to_string().contains("Pose"), "{told}");
        let inside = AccuracyFile::from_toml_str(&FILE.replace("[-0.3, 0.3]", "[-0.2, 0.2]")).unwrap();
        assert!(all_stand(&inside).is_ok());
    }
}
