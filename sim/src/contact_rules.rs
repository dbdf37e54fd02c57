//! Which contacts count: none with the end of a slab in a seam, and only those with floors that are there.

use nalgebra::Point3;
use rapier3d::prelude::{
    ColliderHandle, ContactModificationContext, ModifiableContacts, PairFilterContext, PhysicsHooks, SolverFlags,
};

use crate::convert;
use crate::floors::Touch;
use crate::seams::SeamFilter;

/// Marks the user data of a floor's collider; below it stands the number of its plane.
pub const FLOOR_MARK: u128 = 1 << 64;

/// What a wheel meets: a touch for each plane near it.
pub type Touches = Vec<(usize, Touch)>;

/// The engine's hooks.
#[derive(Clone, Debug, Default)]
pub struct ContactRules {
    /// For walls.
    pub seams: SeamFilter,
    /// The wheels' balls, with what each meets in the tick to be made, for networks with several floors.
    pub treads: Vec<(ColliderHandle, Touches)>,
    /// Radius of a ball, in metres.
    pub radius_m: f64,
}

impl ContactRules {
    /// What a ball meets of a plane; `None` if these are not a ball and a floor.
    fn touch(&self, floor_data: u128, ball: ColliderHandle) -> Option<Touch> {
        let plane = usize::try_from(floor_data.checked_sub(FLOOR_MARK)?).ok()?;
        let (_, touches) = self.treads.iter().find(|(tread, _)| *tread == ball)?;
        Some(touches.iter().find(|(at, _)| *at == plane).map_or(Touch::Away, |(_, touch)| *touch))
    }
}

impl PhysicsHooks for ContactRules {
    fn filter_contact_pair(&self, context: &PairFilterContext<'_>) -> Option<SolverFlags> {
        let data = |collider: ColliderHandle| context.colliders[collider].user_data;
        let [one, two] = [context.collider1, context.collider2];
        let touch = self.touch(data(one), two).or_else(|| self.touch(data(two), one));
        (touch != Some(Touch::Away)).then(SolverFlags::default)
    }

    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let [one, two] = [context.collider1, context.collider2];
        let data = [one, two].map(|collider| context.colliders[collider].user_data);
        if data.iter().all(|data| *data < FLOOR_MARK) {
            return self.seams.modify_solver_contacts(context);
        }
        // A ball over an edge: the half-space has put the contact where the plane goes on.
        let floor_first = data[0] >= FLOOR_MARK;
        let (floor_data, ball) = if floor_first { (data[0], two) } else { (data[1], one) };
        let Some(Touch::Edge { at, normal }) = self.touch(floor_data, ball) else { return };
        let centre = Point3::from(convert::from_vector(context.colliders[ball].translation()));
        let ModifiableContacts::Rigid(contacts) = &mut context.contacts else { return };
        // Normals point from the first collider to the second.
        *contacts.normal = convert::vector(&normal) * if floor_first { 1.0 } else { -1.0 };
        let on_ball = centre - normal.into_inner() * self.radius_m;
        for contact in contacts.solver_contacts.iter_mut() {
            let (on_floor, on_ball) = (convert::point(&at), convert::point(&on_ball));
            (contact.anchor1, contact.anchor2) = if floor_first { (on_floor, on_ball) } else { (on_ball, on_floor) };
            contact.dist = (centre - at).norm() - self.radius_m;
        }
    }
}
