// GLSL of the terrain and of the sky. Colours are display-referred: what is written is what the screen shows.

/** Texels in a row of the textures that hold one texel a vertex. */
export const TEXTURE_WIDTH = 512;

const SKY_COLOUR = /* glsl */ `
  const vec3 HORIZON = vec3(0.80, 0.86, 0.90);
  // Colour of the air in a direction, z up: pale at the horizon, blue above, slate below.
  vec3 skyColour(vec3 direction) {
    vec3 above = mix(HORIZON, vec3(0.25, 0.47, 0.74), pow(max(direction.z, 0.0), 0.55));
    return mix(above, vec3(0.58, 0.66, 0.73), smoothstep(0.0, 0.6, -direction.z));
  }
`;

/** Draws a vertex where its representative is; `blend` runs from the level shown before (0) to the present one (1). */
export const TERRAIN_VERTEX = /* glsl */ `
  uniform sampler2D positions;
  uniform sampler2D squares;
  uniform highp usampler2D places;
  uniform float blend;
  uniform float exaggeration;
  uniform float baseHeight;
  uniform float lift;
  uniform vec3 earthCentre;
  uniform vec3 axis;
  out vec3 fromEye;
  out float height;
  out vec3 up;
  out vec2 square;
  #include <common>
  #include <logdepthbuf_pars_vertex>

  ivec2 texel(int index) {
    return ivec2(index % ${TEXTURE_WIDTH}, index / ${TEXTURE_WIDTH});
  }

  // The ellipsoid's normal, from the Earth-centred position stretched along the axis by 1 / (1 - e^2) - 1.
  vec3 upAt(vec3 position) {
    vec3 radius = position - earthCentre;
    return normalize(radius + axis * (dot(axis, radius) * 0.0067394967));
  }

  void main() {
    uvec2 place = texelFetch(places, texel(gl_VertexID), 0).xy;
    vec4 now = texelFetch(positions, texel(int(place.x)), 0);
    vec4 before = texelFetch(positions, texel(int(place.y)), 0);
    vec4 vertex = mix(before, now, blend);
    vec2 squareNow = texelFetch(squares, texel(int(place.x)), 0).xy;
    square = mix(texelFetch(squares, texel(int(place.y)), 0).xy, squareNow, blend);
    height = vertex.w;
    up = upAt(vertex.xyz);
    vec3 raised = vertex.xyz + up * ((exaggeration - 1.0) * (height - baseHeight));
    vec4 seen = modelViewMatrix * vec4(raised, 1.0);
    fromEye = seen.xyz * mat3(viewMatrix);
    // Towards the eye, so that lines lie on the surface without a change of place on the screen.
    gl_Position = projectionMatrix * vec4(seen.xyz * lift, 1.0);
    #include <logdepthbuf_vertex>
  }
`;

/** What colours mean, in the order of the shader's numbers. */
export const STYLES = ["Elevation", "Hillshade", "Slope", "Certified error", "Imagery"] as const;

/** A style, light from normals or on flat facets, contour lines and haze. */
export const TERRAIN_FRAGMENT = /* glsl */ `
  uniform vec2 heights;
  uniform float landFrom;
  uniform float seaLevel;
  uniform float contourInterval;
  uniform float hazeDistance;
  uniform float exaggeration;
  uniform float clearDistance;
  uniform int style;
  uniform bool contours;
  uniform float certifiedError;
  uniform sampler2D normals;
  uniform vec3 normalsPlace;
  // Finer ones of a part of the square: how wide the square is in them, and where its south-west corner is.
  uniform sampler2D finerNormals;
  uniform vec4 finerPlace;
  // Of its west, south, east and north side: 1 where it ends with the square; and how much of it is seen.
  uniform vec4 finerEnds;
  uniform float finerShare;
  uniform sampler2D picture;
  uniform vec3 picturePlace;
  // Latitude of the base, and from there to the end of the scheme, radians; mercator units of the picture's bottom above the base, and its height.
  uniform vec4 pictureRows;
  // Of the picture's square, radians: its south above the base, and how high it is.
  uniform vec2 pictureLatitudes;
  uniform sampler2D filled;
  uniform bool hasFilled;
  uniform sampler2D water;
  uniform bool hasWater;
  uniform bool showsFilled;
  uniform vec3 axis;
  in vec3 fromEye;
  in float height;
  in vec3 up;
  in vec2 square;
  #include <common>
  #include <logdepthbuf_pars_fragment>
  ${SKY_COLOUR}
  const vec3 SUN = vec3(-0.54, 0.44, 0.72);

  vec3 tint(float share) {
    vec3 colour = mix(vec3(0.24, 0.40, 0.27), vec3(0.45, 0.55, 0.33), smoothstep(0.0, 0.22, share));
    colour = mix(colour, vec3(0.72, 0.68, 0.47), smoothstep(0.18, 0.45, share));
    colour = mix(colour, vec3(0.58, 0.46, 0.36), smoothstep(0.42, 0.66, share));
    colour = mix(colour, vec3(0.66, 0.63, 0.61), smoothstep(0.64, 0.82, share));
    return mix(colour, vec3(0.97, 0.98, 1.0), smoothstep(0.82, 0.96, share));
  }

  // A line a pixel wide at each multiple of the interval, faded out where lines would crowd.
  float contour() {
    float steps = height / contourInterval;
    float width = max(fwidth(steps), 1e-6);
    float line = 1.0 - smoothstep(0.3, 1.1, abs(fract(steps + 0.5) - 0.5) / width);
    return line * smoothstep(0.0, 0.01, width) * (1.0 - smoothstep(0.06, 0.22, width));
  }

  // At a place of a raster that has texels at the corners of its cells.
  vec2 normalAt(sampler2D raster, vec2 place) {
    vec2 corners = vec2(textureSize(raster, 0));
    return texture(raster, (place * (corners - 1.0) + 0.5) / corners).xy;
  }

  // Of finer normals, 0 outside, and from there to 1 within so many cells where they end inside the square.
  float finerPart(vec2 place) {
    vec2 cells = vec2(textureSize(finerNormals, 0)) / 16.0;
    vec4 inside = vec4(place * cells, (1.0 - place) * cells);
    vec4 parts = max(clamp(inside, 0.0, 1.0), finerEnds);
    return finerShare * min(min(parts.x, parts.y), min(parts.z, parts.w));
  }

  // East and north rises of the ground by the rasters of normals.
  vec2 rises() {
    vec2 normal = normalAt(normals, square * normalsPlace.x + normalsPlace.yz);
    if (finerShare > 0.0) {
      vec2 place = square * finerPlace.xy + finerPlace.zw;
      normal = mix(normal, normalAt(finerNormals, place), finerPart(place));
    }
    return -normal / sqrt(max(1.0 - dot(normal, normal), 0.01));
  }

  // What imagery shows. Between two latitudes, mercator rises by 2 atanh(sin(half their difference) / cos(their middle)):
  // exact in single precision, where a difference of two mercator heights is not.
  vec4 pictureColour() {
    vec2 place = square * picturePlace.x + picturePlace.yz;
    float halfway = 0.5 * clamp(pictureLatitudes.x + place.y * pictureLatitudes.y, 0.0, pictureRows.y);
    float risen = 2.0 * atanh(sin(halfway) / cos(pictureRows.x + halfway));
    return texture(picture, vec2(place.x, (risen - pictureRows.z) / pictureRows.w));
  }

  vec3 slopeColour(float degrees) {
    vec3 colour = mix(vec3(0.93, 0.95, 0.90), vec3(0.98, 0.83, 0.40), smoothstep(0.0, 15.0, degrees));
    colour = mix(colour, vec3(0.87, 0.39, 0.20), smoothstep(15.0, 30.0, degrees));
    return mix(colour, vec3(0.36, 0.09, 0.33), smoothstep(30.0, 50.0, degrees));
  }

  // One colour more for each power of ten, from 0.1 to 1000 m.
  vec3 errorColour(float metres) {
    float power = clamp((log2(max(metres, 0.1)) / log2(10.0) + 1.0) / 4.0, 0.0, 1.0);
    vec3 colour = mix(vec3(0.17, 0.37, 0.63), vec3(0.45, 0.76, 0.65), smoothstep(0.0, 0.33, power));
    colour = mix(colour, vec3(0.98, 0.88, 0.55), smoothstep(0.33, 0.66, power));
    return mix(colour, vec3(0.75, 0.18, 0.15), smoothstep(0.66, 1.0, power));
  }

  void main() {
    #include <logdepthbuf_fragment>
    vec3 facet = normalize(cross(dFdx(fromEye), dFdy(fromEye)));
    float level = dot(facet, up);
    // Ground sampled every thirty metres has no walls: what is nearly upright is a sliver, lit as if it were level.
    float slope = sqrt(max(1.0 - level * level, 0.0)) / (max(level, 1e-3) * exaggeration);
    vec3 normal = normalize(mix(facet, up, smoothstep(2.5, 6.0, slope)));
    vec3 east = normalize(cross(axis, up));
    if (normalsPlace.x > 0.0) {
      vec2 rise = rises();
      slope = length(rise);
      normal = normalize(up - exaggeration * (rise.x * east + rise.y * cross(up, east)));
    }
    float flatness = inversesqrt(1.0 + slope * slope);
    float share = (height - landFrom) / max(heights.y - landFrom, 1.0);
    vec3 ground = mix(vec3(0.47, 0.43, 0.39), tint(share), smoothstep(0.45, 0.80, flatness));
    bool isWater = height <= seaLevel || (hasWater && texture(water, square).r > 0.5);
    if (isWater) ground = mix(vec3(0.26, 0.43, 0.54), vec3(0.12, 0.24, 0.37), clamp((height - seaLevel) / min(heights.x - seaLevel, -1.0), 0.0, 1.0));
    if (style == 1) ground = vec3(0.74);
    if (style == 2) ground = slopeColour(degrees(atan(slope)));
    if (style == 3) ground = errorColour(certifiedError);
    // The sun is in the north-west wherever one looks, as on maps.
    float sun = max(dot(normal, normalize(SUN.x * east + SUN.y * cross(up, east) + SUN.z * up)), 0.0);
    vec3 light = vec3(0.47, 0.51, 0.58) * (0.65 + 0.35 * dot(normal, up)) + vec3(0.95, 0.88, 0.75) * sun;
    if (style == 4 && picturePlace.x > 0.0) {
      // Imagery has light of its own.
      vec4 seen = pictureColour();
      ground = mix(ground, seen.rgb, seen.a);
      light = mix(light, vec3(1.0), 0.55 * seen.a);
    }
    if (showsFilled && hasFilled && texture(filled, square).r > 0.5) {
      // Stripes on the screen; nothing of the ground's own colour, which would say something of a certified error.
      float stripe = step(0.5, fract((gl_FragCoord.x + gl_FragCoord.y) / 10.0));
      ground = mix(vec3(0.56, 0.47, 0.66), vec3(0.84, 0.80, 0.88), stripe);
      light = mix(light, vec3(1.0), 0.5);
    }
    vec3 colour = ground * light;
    if (contours && !isWater) colour *= 1.0 - 0.16 * contour();
    float distance = length(fromEye);
    float haze = 1.0 - exp(-pow(max(distance - clearDistance, 0.0) / hazeDistance, 1.6));
    colour = mix(colour, skyColour(fromEye / distance), haze);
    gl_FragColor = vec4(colour, 1.0);
  }
`;

/** The edges of the triangles, fainter far away. */
export const WIRE_FRAGMENT = /* glsl */ `
  uniform float hazeDistance;
  uniform float clearDistance;
  in vec3 fromEye;
  in float height;
  #include <common>
  #include <logdepthbuf_pars_fragment>

  void main() {
    #include <logdepthbuf_fragment>
    gl_FragColor = vec4(0.05, 0.09, 0.16, 0.55 * exp(-max(length(fromEye) - clearDistance, 0.0) / hazeDistance));
  }
`;

/** One triangle over the whole view. */
export const SKY_VERTEX = /* glsl */ `
  out vec3 direction;

  void main() {
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    vec3 ray = vec3(corner.x / projectionMatrix[0][0], corner.y / projectionMatrix[1][1], -1.0);
    direction = ray * mat3(viewMatrix);
    gl_Position = vec4(corner, 0.0, 1.0);
  }
`;

/** The air behind everything. */
export const SKY_FRAGMENT = /* glsl */ `
  in vec3 direction;
  ${SKY_COLOUR}

  void main() {
    gl_FragColor = vec4(skyColour(normalize(direction)), 1.0);
  }
`;
