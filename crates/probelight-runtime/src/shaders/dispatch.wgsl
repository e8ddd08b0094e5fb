// Dispatches of more workgroups than one dimension may have are spread over two.

/// Stands for "no such index".
const NONE: u32 = 0xffffffffu;

fn linear_workgroup(workgroup: vec3u, workgroups: vec3u) -> u32 {
    return workgroup.x + workgroup.y * workgroups.x;
}
