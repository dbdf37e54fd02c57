//! In the steady state the CPU renderer allocates nothing, so its memory stays as it is.

#[path = "../examples/image_hash.rs"]
mod image_hash;

#[test]
fn no_allocation_after_the_first_frames() {
    for picture in image_hash::pictures() {
        println!("{}", picture.name);
        picture.film(1, |render| {
            // There and back: buffers grow to what the fullest frame needs.
            (0..20).for_each(|frame| render(frame, &mut |_| ()));
            let counted = allocation_counter::measure(|| (0..20).rev().for_each(|frame| render(frame, &mut |_| ())));
            assert_eq!(counted.count_total, 0, "{}: {counted:?}", picture.name);
        });
    }
}
