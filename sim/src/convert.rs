//! Between nalgebra, which this project speaks, and glam, which Rapier speaks.

use ductloop_duct::Transform;
use nalgebra::{Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d::math::{Pose, Rotation, Vector};

pub(crate) fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub(crate) fn point(p: &Point3<f64>) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

pub(crate) fn from_vector(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

pub(crate) fn pose(t: &Transform) -> Pose {
    let q = t.rotation.quaternion();
    Pose::from_parts(vector(&t.translation.vector), Rotation::from_xyzw(q.i, q.j, q.k, q.w))
}

pub(crate) fn from_pose(p: &Pose) -> Transform {
    let q = p.rotation;
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(q.w, q.x, q.y, q.z));
    Transform::from_parts(Translation3::from(from_vector(p.translation)), rotation)
}
