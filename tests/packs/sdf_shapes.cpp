// What libsdformat, which Gazebo reads worlds with, finds in a file: origin, and a line for each collision. Fails where it finds a
// fault.
#include <iostream>
#include <sdf/sdf.hh>

int main(int, char **arguments) {
    sdf::Root root;
    for (const auto &error : root.Load(arguments[1])) {
        std::cerr << error << '\n';
        return 1;
    }
    const sdf::World *world = root.WorldByIndex(0);
    const auto *place = world->SphericalCoordinates();
    std::cout.precision(17);
    std::cout << "origin " << place->LongitudeReference().Degree() << ' ' << place->LatitudeReference().Degree() << ' '
              << place->ElevationReference() << '\n';
    const sdf::Link *link = world->ModelByIndex(0)->LinkByIndex(0);
    for (uint64_t index = 0; index < link->CollisionCount(); ++index) {
        const sdf::Collision *collision = link->CollisionByIndex(index);
        if (const sdf::Mesh *mesh = collision->Geom()->MeshShape()) {
            std::cout << "mesh " << mesh->Uri() << ' ' << collision->RawPose().Pos() << '\n';
        } else if (const sdf::Heightmap *heights = collision->Geom()->HeightmapShape()) {
            std::cout << "heightmap " << heights->Uri() << ' ' << heights->Size() << ' ' << heights->Position() << '\n';
        }
    }
    return world->ModelByIndex(0)->Static() ? 0 : 1;
}
