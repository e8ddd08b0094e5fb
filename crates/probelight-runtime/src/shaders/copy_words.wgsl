// Copies an array: what the memory can do, to compare the stages with.

@group(0) @binding(0) var<storage, read> source: array<vec4u>;
@group(0) @binding(1) var<storage, read_write> copied: array<vec4u>;

@compute @workgroup_size(256)
fn copy_words(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    // Neighbouring invocations move neighbouring words, each of them four times 16 bytes.
    let first = linear_workgroup(workgroup, workgroups) * 1024u + local;
    for (var i = 0u; i < 4u; i++) {
        let word = first + 256u * i;
        if word < arrayLength(&source) {
            copied[word] = source[word];
        }
    }
}
