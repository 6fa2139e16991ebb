// What SimGear, which FlightGear reads scenery with, finds in a file: version, centre and radius; the folder and the number of the bucket
// that the centre is in; all vertices with their normals and places on textures; the triangles of each material.
#include <iostream>
#include <simgear/bucket/newbucket.hxx>
#include <simgear/io/sg_binobj.hxx>
#include <simgear/misc/sg_path.hxx>

int main(int, char **arguments) {
    SGBinObject file;
    if (!file.read_bin(SGPath(arguments[1]))) {
        return 1;
    }
    std::cout.precision(17);
    const SGVec3d centre = file.get_gbs_center();
    std::cout << "sphere " << file.get_version() << ' ' << centre.x() << ' ' << centre.y() << ' ' << centre.z() << ' '
              << file.get_gbs_radius() << '\n';
    const SGBucket bucket(SGGeod::fromCart(centre));
    std::cout << "bucket " << bucket.gen_base_path() << ' ' << bucket.gen_index() << ' ' << bucket.get_center_lon() << ' '
              << bucket.get_center_lat() << ' ' << bucket.get_width() << ' ' << bucket.get_height() << '\n';
    const auto &nodes = file.get_wgs84_nodes();
    for (size_t index = 0; index < nodes.size(); ++index) {
        const SGVec3d at = centre + nodes[index];
        const SGVec3f normal = file.get_normals().at(index);
        const SGVec2f texture = file.get_texcoords().at(index);
        std::cout << "v " << at.x() << ' ' << at.y() << ' ' << at.z() << ' ' << normal.x() << ' ' << normal.y() << ' '
                  << normal.z() << ' ' << texture.x() << ' ' << texture.y() << '\n';
    }
    const auto &groups = file.get_tris_v();
    for (size_t group = 0; group < groups.size(); ++group) {
        if (file.get_tris_n()[group] != groups[group] || file.get_tris_tcs()[group][0] != groups[group]) {
            return 1;
        }
        for (size_t corner = 0; corner + 2 < groups[group].size(); corner += 3) {
            std::cout << "t " << file.get_tri_materials()[group] << ' ' << groups[group][corner] << ' ' << groups[group][corner + 1]
                      << ' ' << groups[group][corner + 2] << '\n';
        }
    }
}
