//! Counts collisions: contacts of any part of the robot but the balls it drives on with anything.

use rapier3d::math::Vector;
use rapier3d::prelude::{ColliderHandle, ColliderSet, NarrowPhase, RigidBodyHandle, RigidBodySet};

/// After the last touch, for how long another one is still the same collision, in s.
pub const SAME_COLLISION_S: f64 = 0.1;

/// What the robot bumped into so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Collisions {
    /// How often it began to touch something. Sliding along a wall is one collision, however long.
    pub count: u32,
    /// Largest speed at which a part approached what it hit, along the contact's normal, just before the contact, in m/s.
    pub contact_speed_max_m_s: f64,
}

/// Turns touches, tick by tick, into collisions.
#[derive(Clone, Debug)]
pub struct CollisionCounter {
    collisions: Collisions,
    last_touch: Option<u64>,
    same_ticks: u64,
}

impl CollisionCounter {
    /// Nothing touched yet.
    pub fn new(physics_hz: u32) -> Self {
        let same_ticks = (SAME_COLLISION_S * f64::from(physics_hz)).round() as u64;
        Self { collisions: Collisions::default(), last_touch: None, same_ticks }
    }

    /// Notes the approach speed of what was touched in this tick, if anything was.
    pub fn note(&mut self, tick: u64, touch_m_s: Option<f64>) {
        let Some(speed) = touch_m_s else { return };
        if self.last_touch.is_none_or(|last| tick - last > self.same_ticks) {
            self.collisions.count += 1;
        }
        self.last_touch = Some(tick);
        self.collisions.contact_speed_max_m_s = self.collisions.contact_speed_max_m_s.max(speed);
    }

    /// The collisions so far.
    pub fn collisions(&self) -> Collisions {
        self.collisions
    }
}

/// A body's motion at an instant.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    linear: Vector,
    angular: Vector,
    centre: Vector,
}

impl Motion {
    /// How a body moves now.
    pub fn of(body: RigidBodyHandle, bodies: &RigidBodySet) -> Self {
        let body = &bodies[body];
        Self { linear: body.linvel(), angular: body.angvel(), centre: body.center_of_mass() }
    }

    fn at(&self, point: Vector) -> Vector {
        self.linear + self.angular.cross(point - self.centre)
    }
}

/// Largest approach speed, in m/s, of the parts of `shell` that something pushed on in the step just made; `None` if nothing
/// did. `before` holds each part's motion before that step: the contact itself has already slowed the part down.
pub fn touch(narrow_phase: &NarrowPhase, colliders: &ColliderSet, shell: &[ColliderHandle], before: &[Motion]) -> Option<f64> {
    let mut fastest: Option<f64> = None;
    for (part, motion) in shell.iter().zip(before) {
        for pair in narrow_phase.contact_pairs_with(*part) {
            // Manifolds' normals point from the first collider to the second.
            let away = if pair.collider1 == *part { -1.0 } else { 1.0 };
            // Contacts that were dropped keep the impulse of their last time.
            for manifold in pair.manifolds().iter().filter(|manifold| !manifold.data.solver_contacts.is_empty()) {
                for contact in manifold.points.iter().filter(|contact| contact.data.impulse > 0.0) {
                    let point = colliders[pair.collider1].position() * contact.local_p1;
                    let approach = -motion.at(point).dot(manifold.data.normal) * away;
                    fastest = Some(fastest.unwrap_or(0.0).max(approach));
                }
            }
        }
    }
    fastest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn touches_within_a_tenth_of_a_second_of_the_last_loss_are_one_collision() {
        let mut counter = CollisionCounter::new(1000);
        for (tick, speed) in [(10, 0.2), (11, 0.0), (111, 0.3), (212, 0.1), (213, 0.0)] {
            counter.note(tick, None);
            counter.note(tick, Some(speed));
        }
        // 11 to 111 is 0.1 s: the same; 111 to 212 is more: another.
        assert_eq!(counter.collisions(), Collisions { count: 2, contact_speed_max_m_s: 0.3 });
    }
}
