// The pixels that small cylinders have claimed.
#import "cylinder_listed.wgsl"
#import "owner.wgsl"

@vertex
fn vs_small(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4<f32> {
    return small_corner(corner);
}

@fragment
fn fs_cylinder_small(@builtin(position) fragment: vec4<f32>) -> Surface {
    let number = owner_of(fragment);
    if number == NOBODY {
        discard;
    }
    let stick = listed(number);
    let cylinder = placed_cylinder(stick.a_radius, stick.b, stick.look.z);
    return cylinder_surface(vertex_of(cylinder, fragment, vec4<u32>(stick.look, placed_id(stick.id))));
}
