//! Between keyframes.

/// The keyframe at a time, and, between two, the next one and how far it is on the way there. Before the first and after the last
/// it is that. `time_of` is when a keyframe is; they come in the order of time.
pub(super) fn keys_at<K>(
    keys: &[K],
    time: f32,
    time_of: impl Fn(&K) -> f32,
) -> Option<(&K, Option<(&K, f32)>)> {
    let next = keys.partition_point(|key| time_of(key) <= time);
    match (next.checked_sub(1).and_then(|last| keys.get(last)), keys.get(next)) {
        (Some(from), Some(to)) => {
            let share = (time - time_of(from)) / (time_of(to) - time_of(from));
            Some((from, Some((to, share))))
        }
        (only, other) => Some((only.or(other)?, None)),
    }
}
