// GLSL that turns patches into triangles: each vertex of a template lattice finds its point on its instance's patch.

/** Texels in a row of the texture of control points. */
export const TEXTURE_WIDTH = 2040;

const POINTS = /* glsl */ `
  precision highp float;
  precision highp int;
  uniform highp sampler2D points;
  uniform mat4 modelViewMatrix;
  uniform mat4 projectionMatrix;
  // A patch; and the factors of its curves AB, BC and CA as exponents of two in four bits each, then which run the other way.
  in uvec2 instance;

  vec3 controlPoint(int index) {
    int texel = int(instance.x) * 10 + index;
    return texelFetch(points, ivec2(texel % ${TEXTURE_WIDTH}, texel / ${TEXTURE_WIDTH}), 0).xyz;
  }
`;

/** Patches as shaded triangles. On a curve, both patches compute the same points with the same operations: there are no cracks. */
export const PATCH_VERTEX = /* glsl */ `
  ${POINTS}
  uniform int steps;
  // Barycentric coordinates in steps of the template.
  in uvec3 place;
  out vec3 normal;
  out vec3 seen;
  invariant gl_Position;

  // The point at m chords of f, counted in the direction in which the curve is stored.
  vec3 onCurve(vec3 a, vec3 b, vec3 c, vec3 d, int m, int f) {
    float t = float(m) / float(f);
    float s = 1.0 - t;
    return s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d;
  }

  void main() {
    ivec3 corner = ivec3(place);
    vec3 p[10];
    for (int index = 0; index < 10; index++) p[index] = controlPoint(index);
    vec3 at = vec3(corner) / float(steps);
    // On curve AB, BC or CA the coordinate of the third corner is 0; the next corner's counts steps along it.
    int curve = corner.z == 0 ? 0 : corner.x == 0 ? 1 : corner.y == 0 ? 2 : -1;
    vec3 position = vec3(0.0);
    if (curve >= 0) {
      int along = curve == 0 ? corner.y : curve == 1 ? corner.z : corner.x;
      int chords = 1 << int((instance.y >> (4 * curve)) & 15u);
      int m = (along * chords + steps / 2) / steps;
      float t = float(m) / float(chords);
      at = curve == 0 ? vec3(1.0 - t, t, 0.0) : curve == 1 ? vec3(0.0, 1.0 - t, t) : vec3(t, 0.0, 1.0 - t);
      vec3 a = curve == 0 ? p[0] : curve == 1 ? p[6] : p[9];
      vec3 b = curve == 0 ? p[1] : curve == 1 ? p[7] : p[5];
      vec3 c = curve == 0 ? p[3] : curve == 1 ? p[8] : p[2];
      vec3 d = curve == 0 ? p[6] : curve == 1 ? p[9] : p[0];
      bool isReversed = ((instance.y >> (12 + curve)) & 1u) == 1u;
      position = isReversed ? onCurve(d, c, b, a, chords - m, chords) : onCurve(a, b, c, d, m, chords);
    }
    // De Casteljau's algorithm, down to the triangle that touches the patch.
    vec3 q[6] = vec3[6](
      at.x * p[0] + at.y * p[1] + at.z * p[2], at.x * p[1] + at.y * p[3] + at.z * p[4],
      at.x * p[2] + at.y * p[4] + at.z * p[5], at.x * p[3] + at.y * p[6] + at.z * p[7],
      at.x * p[4] + at.y * p[7] + at.z * p[8], at.x * p[5] + at.y * p[8] + at.z * p[9]);
    vec3 a = at.x * q[0] + at.y * q[1] + at.z * q[2];
    vec3 b = at.x * q[1] + at.y * q[3] + at.z * q[4];
    vec3 c = at.x * q[2] + at.y * q[4] + at.z * q[5];
    if (curve < 0) position = at.x * a + at.y * b + at.z * c;
    normal = mat3(modelViewMatrix) * cross(b - a, c - a);
    vec4 inView = modelViewMatrix * vec4(position, 1.0);
    seen = inView.xyz;
    gl_Position = projectionMatrix * inView;
  }
`;

export const PATCH_FRAGMENT = /* glsl */ `
  precision highp float;
  in vec3 normal;
  in vec3 seen;
  out vec4 colour;

  void main() {
    // Where a patch has no tangent plane, the triangle's own.
    vec3 facet = cross(dFdx(seen), dFdy(seen));
    vec3 towards = normalize(dot(normal, normal) > 0.0 ? normal : facet);
    vec3 clay = gl_FrontFacing ? vec3(0.80, 0.72, 0.60) : vec3(0.50, 0.56, 0.64);
    if (dot(towards, seen) > 0.0) towards = -towards;
    float key = max(dot(towards, normalize(vec3(-0.4, 0.7, 0.6))), 0.0);
    float shine = pow(max(dot(reflect(normalize(seen), towards), normalize(vec3(-0.4, 0.7, 0.6))), 0.0), 40.0);
    colour = vec4(clay * (0.28 + 0.72 * key) + 0.25 * shine, 1.0);
  }
`;

/** The nets of control points as lines. */
export const NET_VERTEX = /* glsl */ `
  ${POINTS}
  in uint point;

  void main() {
    vec4 inView = modelViewMatrix * vec4(controlPoint(int(point)), 1.0);
    // Towards the eye, so that what lies on the surface is seen.
    gl_Position = projectionMatrix * vec4(inView.xyz * 0.998, 1.0);
  }
`;

export const NET_FRAGMENT = /* glsl */ `
  precision highp float;
  out vec4 colour;
  void main() {
    colour = vec4(0.08, 0.14, 0.24, 1.0);
  }
`;
