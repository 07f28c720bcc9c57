// The pixels that small spheres have claimed.
#import "sphere_listed.wgsl"
#import "owner.wgsl"

@vertex
fn vs_small(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4<f32> {
    return small_corner(corner);
}

@fragment
fn fs_sphere_small(@builtin(position) fragment: vec4<f32>) -> Surface {
    let number = owner_of(fragment);
    if number == NOBODY {
        discard;
    }
    let first = 3u * number;
    let last = bitcast<vec2<f32>>(spheres[first + 1u]);
    let look = spheres[first + 2u];
    let ball = vec4<f32>(view_point(vec3<f32>(bitcast<vec2<f32>>(spheres[first]), last.x)), last.y);
    return sphere_surface(SphereVertex(fragment, ball, vec2<u32>(look.x, placed_id(look.y))));
}
