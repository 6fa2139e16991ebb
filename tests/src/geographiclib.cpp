// GeographicLib for Rust: plain functions, and no exception leaves them. Each returns 0, or 1 where GeographicLib threw.

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/Geodesic.hpp>
#include <GeographicLib/UTMUPS.hpp>

#include <vector>

using namespace GeographicLib;

namespace {
template <typename Work> int guarded(Work work) {
    try {
        work();
        return 0;
    } catch (...) {
        return 1;
    }
}
}

extern "C" {

// position: x, y, z; rotation: rows of the matrix from east, north, up to x, y, z.
int shim_to_earth_centred(double latitude, double longitude, double height, double position[3], double rotation[9]) {
    return guarded([&] {
        std::vector<double> matrix(9);
        Geocentric::WGS84().Forward(latitude, longitude, height, position[0], position[1], position[2], matrix);
        for (int i = 0; i < 9; ++i) rotation[i] = matrix[i];
    });
}

int shim_to_geodetic(double x, double y, double z, double geodetic[3]) {
    return guarded([&] { Geocentric::WGS84().Reverse(x, y, z, geodetic[0], geodetic[1], geodetic[2]); });
}

int shim_distance(double latitude1, double longitude1, double latitude2, double longitude2, double *metres) {
    return guarded([&] { Geodesic::WGS84().Inverse(latitude1, longitude1, latitude2, longitude2, *metres); });
}

int shim_from_utm(int zone, int north, double easting, double northing, double geodetic[2]) {
    return guarded([&] { UTMUPS::Reverse(zone, north != 0, easting, northing, geodetic[0], geodetic[1]); });
}
}
