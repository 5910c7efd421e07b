// The yardstick: candela's direct light on Embree 3 or 4, as a careful C++ renderer would do it.
//
//   yardstick SCENE.bin BUILD_THREADS
//
// Camera rays go in coherent packets of 16 (4 x 4 pixels), shadow rays in one occlusion packet for each
// light; threads take tiles of 16 x 16 pixels from a counter. Shading works on 16 lanes at a time in f32,
// for the compiler to vectorize (-O3 -march=native -ffast-math).
//
// SCENE.bin is what benches/speed/yardstick.rs writes: 32-bit numbers in the machine's byte order.
// The program prints `ready LOAD BUILD MAJOR.MINOR.PATCH`, then obeys a command in each line of its input
// and answers each with one line:
//
//   render SAMPLES THREADS LIGHTS    render with the first LIGHTS lights; answers the seconds
//   shade SAMPLES THREADS LIGHTS     the same, but no ray is traced: all pixels see one plane, lit by all
//   save FILE                        write the last image: R, G, B as f32, row by row from the top
#include "packets.h"

#include <cstdlib>
#include <iostream>

namespace {

// How far shadow rays start from the surface, as a share of the magnitudes that its position was computed
// from: a few tens of roundings.
constexpr float OFFSET = 1e-6f;

struct Light {
  Vec3 position, intensity;
};

struct Material {
  Vec3 diffuse, specular;
  float shininess;
};

// All shapes of one kind and material: one geometry of Embree's, with the same index.
struct Part {
  enum Kind : uint32_t { SPHERES = 0, FLAT = 1, SMOOTH = 2 };
  Material material;
  std::vector<Vec3> normals;               // of SMOOTH
  std::vector<uint32_t> normal_corners;    // three for each triangle
};

// A camera ray is linear in the pixel: at column x and row y it is origin + x * origin_x + y * origin_y, and
// its direction likewise.
struct Camera {
  Vec3 origin, origin_x, origin_y, direction, direction_x, direction_y;
};

class Renderer {
 public:
  Renderer(const char* path, int threads) {
    const auto start = std::chrono::steady_clock::now();
    Reader reader(path);
    const auto width = reader.one<uint32_t>(), height = reader.one<uint32_t>();
    image = Image(int(width), int(height));
    camera = reader.one<Camera>();
    lights = reader.list<Light>();
    background = reader.one<Vec3>();
    device = new_device(threads);
    scene = new_scene(device);
    parts.resize(reader.one<uint32_t>());
    std::vector<RTCGeometry> geometries;
    for (Part& part : parts) geometries.push_back(geometry(reader, part));
    load = seconds_since(start);

    const auto build_start = std::chrono::steady_clock::now();
    for (RTCGeometry geometry : geometries) attach(scene, geometry);
    commit(device, scene);
    build = seconds_since(build_start);
  }

  template <bool TRACE>
  double render(int samples, int threads, int light_count) {
    if (light_count > int(lights.size())) throw std::runtime_error("the scene has fewer lights");
    const auto start = std::chrono::steady_clock::now();
    for_packets(image.width, image.height, threads, [&](int x, int y) { pixels<TRACE>(x, y, samples, light_count); });
    return seconds_since(start);
  }

  void save(const std::string& path) const { image.save(path); }

  std::string ready() const {
    return "ready " + std::to_string(load) + " " + std::to_string(build) + " " + version(device);
  }

 private:
  RTCGeometry geometry(Reader& reader, Part& part) {
    const auto kind = Part::Kind(reader.one<uint32_t>());
    part.material = reader.one<Material>();
    if (kind == Part::SPHERES) return read_spheres(device, reader);
    RTCGeometry mesh = read_triangles(device, reader);
    if (kind == Part::SMOOTH) {
      part.normals = reader.list<Vec3>();
      part.normal_corners = reader.list<uint32_t>();
    }
    return mesh;
  }

  // All samples of 4 x 4 pixels.
  template <bool TRACE>
  void pixels(int left, int top, int samples, int light_count) {
    Lanes3 sum{};
    for (int sample = 0; sample < samples; sample++) {
      const float dx = (sample + .5f) / samples, dy = radical_inverse(sample) + .5f / samples;
      alignas(64) RTCRayHit16 packet;
      alignas(64) int valid[LANES];
      for (int k = 0; k < LANES; k++) {
        const int column = left + k % PACKET_SIDE, row = top + k / PACKET_SIDE;
        const float x = column + dx, y = row + dy;
        valid[k] = image.holds(column, row) ? -1 : 0;
        const Vec3 origin{camera.origin.x + x * camera.origin_x.x + y * camera.origin_y.x,
                          camera.origin.y + x * camera.origin_x.y + y * camera.origin_y.y,
                          camera.origin.z + x * camera.origin_x.z + y * camera.origin_y.z};
        const Vec3 direction{camera.direction.x + x * camera.direction_x.x + y * camera.direction_y.x,
                             camera.direction.y + x * camera.direction_x.y + y * camera.direction_y.y,
                             camera.direction.z + x * camera.direction_x.z + y * camera.direction_y.z};
        set_ray(packet, k, origin, direction);
      }
      if (TRACE) {
        find_nearest(valid, scene, packet, Rays::COHERENT);
      } else {
        for (int k = 0; k < LANES; k++) {
          packet.ray.tfar[k] = 1;
          packet.hit.geomID[k] = packet.hit.primID[k] = 0;
          packet.hit.Ng_x[k] = packet.hit.Ng_z[k] = 0;
          packet.hit.Ng_y[k] = 1;
        }
      }
      shade<TRACE>(packet, valid, light_count, sum);
    }
    image.put(left, top, sum, samples);
  }

  // The normals of a smooth mesh between its vertices, in place of `normal`, on the same side.
  void interpolate(const RTCRayHit16& packet, int k, Lanes3& normal) const {
    const Part& part = parts[packet.hit.geomID[k]];
    if (part.normals.empty()) return;
    const uint32_t* corner = &part.normal_corners[3 * size_t(packet.hit.primID[k])];
    const Vec3 a = part.normals[corner[0]], b = part.normals[corner[1]], c = part.normals[corner[2]];
    const float u = packet.hit.u[k], v = packet.hit.v[k], w = 1 - u - v;
    const Vec3 n{w * a.x + u * b.x + v * c.x, w * a.y + u * b.y + v * c.y, w * a.z + u * b.z + v * c.z};
    const float side = n.x * normal.x[k] + n.y * normal.y[k] + n.z * normal.z[k] < 0 ? -1 : 1;
    const float scale = side / std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    normal.x[k] = n.x * scale;
    normal.y[k] = n.y * scale;
    normal.z[k] = n.z * scale;
  }

  // Adds the light of all lights at the hits of a packet.
  template <bool TRACE>
  void shade(const RTCRayHit16& packet, const int* valid, int light_count, Lanes3& sum) const {
    const auto& ray = packet.ray;
    Lanes3 point, geometric, normal, diffuse, specular;
    Lanes shininess;
    alignas(64) int hit[LANES];
    for (int k = 0; k < LANES; k++) {
      hit[k] = valid[k] & (packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID ? -1 : 0);
      const float missed = valid[k] & ~hit[k] ? 1 : 0;
      sum.x[k] += missed * background.x;
      sum.y[k] += missed * background.y;
      sum.z[k] += missed * background.z;
      find_point(packet, k, hit[k], OFFSET, point, geometric);
    }
    normal = geometric;
    // Most packets hit one part only.
    const int first = int(std::find(hit, hit + LANES, -1) - hit);
    if (first == LANES) return;
    const uint32_t part = packet.hit.geomID[first];
    bool is_one_part = true;
    for (int k = 0; k < LANES; k++) is_one_part &= !hit[k] || packet.hit.geomID[k] == part;
    auto set_material = [&](int k, const Material& material) {
      diffuse.x[k] = material.diffuse.x;
      diffuse.y[k] = material.diffuse.y;
      diffuse.z[k] = material.diffuse.z;
      specular.x[k] = material.specular.x;
      specular.y[k] = material.specular.y;
      specular.z[k] = material.specular.z;
      shininess[k] = material.shininess;
    };
    if (is_one_part) {
      const Material material = parts[part].material;
      for (int k = 0; k < LANES; k++) set_material(k, material);
    } else {
      for (int k = 0; k < LANES; k++) set_material(k, parts[hit[k] ? packet.hit.geomID[k] : part].material);
    }
    if (TRACE && !(is_one_part && parts[part].normals.empty())) {
      for (int k = 0; k < LANES; k++)
        if (hit[k]) interpolate(packet, k, normal);
    }
    for (int l = 0; l < light_count; l++) {
      const Light& light = lights[l];
      alignas(64) RTCRay16 shadow;
      alignas(64) int lit[LANES];
      Lanes matt, glossy;
      for (int k = 0; k < LANES; k++) {
        float x = light.position.x - point.x[k], y = light.position.y - point.y[k], z = light.position.z - point.z[k];
        const float square = x * x + y * y + z * z, scale = 1 / std::sqrt(square), distance = square * scale;
        x *= scale;
        y *= scale;
        z *= scale;
        const float above = geometric.x[k] * x + geometric.y[k] * y + geometric.z[k] * z;
        const float cosine = normal.x[k] * x + normal.y[k] * y + normal.z[k] * z;
        const float rx = 2 * cosine * normal.x[k] - x, ry = 2 * cosine * normal.y[k] - y,
                    rz = 2 * cosine * normal.z[k] - z;
        const float lobe = -(rx * ray.dir_x[k] + ry * ray.dir_y[k] + rz * ray.dir_z[k]);
        const float power = std::exp2(shininess[k] * std::log2(std::max(lobe, 1e-30f)));
        lit[k] = hit[k] & (above > 0 ? -1 : 0);
        matt[k] = std::max(cosine, 0.f) * scale * scale;
        glossy[k] = (lobe > 0 ? power : 0) * scale * scale;
        set_shadow_ray(shadow, k, {point.x[k], point.y[k], point.z[k]}, {x, y, z}, distance);
      }
      if (TRACE) find_occluded(lit, scene, shadow, Rays::COHERENT);
      for (int k = 0; k < LANES; k++) {
        const float seen = lit[k] && shadow.tfar[k] >= 0 ? 1.f : 0.f;
        sum.x[k] += seen * light.intensity.x * (diffuse.x[k] * matt[k] + specular.x[k] * glossy[k]);
        sum.y[k] += seen * light.intensity.y * (diffuse.y[k] * matt[k] + specular.y[k] * glossy[k]);
        sum.z[k] += seen * light.intensity.z * (diffuse.z[k] * matt[k] + specular.z[k] * glossy[k]);
      }
    }
  }

  Camera camera;
  Vec3 background;
  std::vector<Light> lights;
  std::vector<Part> parts;
  RTCDevice device;
  RTCScene scene;
  Image image;
  double load, build;
};

}  // namespace

int main(int count, char** arguments) try {
  if (count != 3) throw std::runtime_error("usage: yardstick SCENE.bin BUILD_THREADS");
  Renderer renderer(arguments[1], std::atoi(arguments[2]));
  std::cout << renderer.ready() << std::endl;
  std::string command;
  while (std::cin >> command) {
    if (command == "save") {
      std::string path;
      std::getline(std::cin >> std::ws, path);
      renderer.save(path);
      std::cout << "saved" << std::endl;
    } else {
      int samples, threads, lights;
      if (!(std::cin >> samples >> threads >> lights)) throw std::runtime_error(command + ": three numbers are missing");
      if (command == "render")
        std::cout << renderer.render<true>(samples, threads, lights) << std::endl;
      else if (command == "shade")
        std::cout << renderer.render<false>(samples, threads, lights) << std::endl;
      else
        throw std::runtime_error("no such command: " + command);
    }
  }
} catch (const std::exception& error) {
  std::cerr << "yardstick: " << error.what() << std::endl;
  return 1;
}
