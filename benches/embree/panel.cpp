// A room under a panel on Embree 3 or 4: direct light of one rectangle, by N x N points of it.
//
//   panel SCENE.bin BUILD_THREADS
//
// Camera rays go in coherent packets of 16 (4 x 4 pixels). For each point of the panel, one packet of shadow rays
// asks for those of the 16 hits that are above its horizon and before its front; where there is none, nothing is
// asked. Threads take tiles of 16 x 16 pixels from a counter; shading works on 16 lanes at a time in f32, for the
// compiler to vectorize (-O3 -march=native -ffast-math).
//
// SCENE.bin is what benches/areas/room.py writes: 32-bit numbers in the machine's byte order. The program prints
// `ready MAJOR.MINOR.PATCH`, then obeys a command in each line of its input and answers each with one line:
//
//   render SAMPLES THREADS N POINTS    render; answers the seconds, and those of all processors. Each sample of a pixel
//                                      asks one point in each of N x N cells of the panel: with POINTS `centers` its
//                                      middle, with `spread` a multijittered place. So are the pixel's samples then
//   save FILE                          write the last image: R, G, B as f32, row by row from the top
#include "packets.h"

#include <cstdlib>
#include <ctime>
#include <iostream>
#include <numeric>
#include <random>

namespace {

// How far shadow rays start from the surface, as a share of the magnitudes that its position was computed from, and
// how far of the way to the panel they go, so that they do not meet it.
constexpr float OFFSET = 1e-6f, WAY = 1 - 1e-4f;

// A corner, two sides, the normal of its front, and what it sends.
struct Panel {
  Vec3 corner, u, v, normal, luminance;
};

// All shapes of one kind and material: one geometry of Embree's, with the same index.
struct Part {
  enum Kind : uint32_t { SPHERES = 0, FLAT = 1, PANEL = 2 };
  Kind kind;
  Vec3 diffuse;
};

// At column x and row y a camera ray's direction is direction + x * direction_x + y * direction_y.
struct Camera {
  Vec3 origin, direction, direction_x, direction_y;
};

uint32_t scrambled(uint32_t n) {
  n = (n ^ (n >> 16)) * 0x7feb352du;
  n = (n ^ (n >> 15)) * 0x846ca68bu;
  return n ^ (n >> 16);
}

// A place in a cell.
struct Place {
  float u, v;
};

// Multijittered places, one for each sample of a pixel: each row, each column and each cell of a grid has its own, in
// random order. As many patterns as pixels need, not to look alike.
constexpr uint32_t PATTERNS = 256;

std::vector<Place> multijittered(int samples) {
  int columns = int(std::sqrt(float(samples)));
  while (samples % columns) columns--;
  const int rows = samples / columns;
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<Place> places;
  std::vector<int> u(static_cast<size_t>(rows)), v(static_cast<size_t>(columns));
  std::iota(u.begin(), u.end(), 0);
  std::iota(v.begin(), v.end(), 0);
  for (uint32_t pattern = 0; pattern < PATTERNS; pattern++) {
    const size_t first = places.size();
    std::vector<std::vector<int>> u_of_column(size_t(columns), u), v_of_row(size_t(rows), v);
    for (auto& order : u_of_column) std::shuffle(order.begin(), order.end(), random);
    for (auto& order : v_of_row) std::shuffle(order.begin(), order.end(), random);
    for (int row = 0; row < rows; row++)
      for (int column = 0; column < columns; column++)
        places.push_back({(float(column) + (float(u_of_column[column][row]) + unit(random)) / rows) / columns,
                          (float(row) + (float(v_of_row[row][column]) + unit(random)) / columns) / rows});
    std::shuffle(places.begin() + ptrdiff_t(first), places.end(), random);
  }
  return places;
}

class Renderer {
 public:
  Renderer(const char* path, int threads) {
    Reader reader(path);
    const auto width = reader.one<uint32_t>(), height = reader.one<uint32_t>();
    image = Image(int(width), int(height));
    camera = reader.one<Camera>();
    panel = reader.one<Panel>();
    const Vec3 u = panel.u, v = panel.v;
    const Vec3 across{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
    area = std::sqrt(across.x * across.x + across.y * across.y + across.z * across.z);
    device = new_device(threads);
    scene = new_scene(device);
    parts.resize(reader.one<uint32_t>());
    for (Part& part : parts) {
      part.kind = Part::Kind(reader.one<uint32_t>());
      part.diffuse = reader.one<Vec3>();
      attach(scene, part.kind == Part::SPHERES ? read_spheres(device, reader) : read_triangles(device, reader));
    }
    commit(device, scene);
  }

  double render(int samples, int threads, int side, bool is_spread) {
    const auto start = std::chrono::steady_clock::now();
    if (is_spread) places = multijittered(samples);
    for_packets(image.width, image.height, threads, [&](int x, int y) {
      is_spread ? pixels<true>(x, y, samples, side) : pixels<false>(x, y, samples, side);
    });
    return seconds_since(start);
  }

  void save(const std::string& path) const { image.save(path); }

  std::string ready() const { return "ready " + version(device); }

 private:
  // All samples of 4 x 4 pixels.
  template <bool SPREAD>
  void pixels(int left, int top, int samples, int side) {
    Lanes3 sum{};
    // Which patterns each pixel's points in their cells and its rays have.
    const Place *pattern[LANES] = {}, *rays[LANES] = {};
    if (SPREAD)
      for (int k = 0; k < LANES; k++) {
        const uint32_t column = uint32_t(left + k % PACKET_SIDE), row = uint32_t(top + k / PACKET_SIDE);
        const uint32_t pixel = scrambled(row * uint32_t(image.width) + column);
        pattern[k] = &places[size_t(pixel % PATTERNS) * samples];
        rays[k] = &places[size_t((pixel + PATTERNS / 2) % PATTERNS) * samples];
      }
    for (int sample = 0; sample < samples; sample++) {
      const Place hammersley{(sample + .5f) / samples, radical_inverse(sample) + .5f / samples};
      alignas(64) RTCRayHit16 packet;
      alignas(64) int valid[LANES];
      for (int k = 0; k < LANES; k++) {
        const int column = left + k % PACKET_SIDE, row = top + k / PACKET_SIDE;
        const Place place = SPREAD ? rays[k][sample] : hammersley;
        const float x = column + place.u, y = row + place.v;
        valid[k] = image.holds(column, row) ? -1 : 0;
        const Vec3 direction{camera.direction.x + x * camera.direction_x.x + y * camera.direction_y.x,
                             camera.direction.y + x * camera.direction_x.y + y * camera.direction_y.y,
                             camera.direction.z + x * camera.direction_x.z + y * camera.direction_y.z};
        set_ray(packet, k, camera.origin, direction);
      }
      find_nearest(valid, scene, packet, Rays::COHERENT);
      Lanes offset_u, offset_v;
      for (int k = 0; k < LANES; k++) {
        const Place place = SPREAD ? pattern[k][sample] : Place{.5f, .5f};
        offset_u[k] = place.u;
        offset_v[k] = place.v;
      }
      shade<SPREAD>(packet, valid, side, offset_u, offset_v, sum);
    }
    image.put(left, top, sum, samples);
  }

  // Adds the panel's light at the hits of a packet.
  template <bool SPREAD>
  void shade(const RTCRayHit16& packet, const int* valid, int side, const Lanes& offset_u, const Lanes& offset_v,
             Lanes3& sum) const {
    const auto& ray = packet.ray;
    Lanes3 point, normal, diffuse;
    alignas(64) int hit[LANES];
    for (int k = 0; k < LANES; k++) {
      hit[k] = valid[k] & (packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID ? -1 : 0);
      find_point(packet, k, hit[k], OFFSET, point, normal);
    }
    for (int k = 0; k < LANES; k++) {
      if (!hit[k]) continue;
      const Part& part = parts[packet.hit.geomID[k]];
      diffuse.x[k] = part.diffuse.x;
      diffuse.y[k] = part.diffuse.y;
      diffuse.z[k] = part.diffuse.z;
      if (part.kind != Part::PANEL) continue;
      const Vec3 front = panel.normal;
      if (front.x * ray.dir_x[k] + front.y * ray.dir_y[k] + front.z * ray.dir_z[k] < 0) {
        sum.x[k] += panel.luminance.x;
        sum.y[k] += panel.luminance.y;
        sum.z[k] += panel.luminance.z;
      }
      hit[k] = 0;
    }
    // Where nothing of the panel's front is above the horizon, none of its points is asked.
    int any = 0;
    for (int k = 0; k < LANES; k++) {
      const Vec3 c = panel.corner;
      const float x = c.x - point.x[k], y = c.y - point.y[k], z = c.z - point.z[k];
      const float before = panel.normal.x * x + panel.normal.y * y + panel.normal.z * z;
      const float u = normal.x[k] * panel.u.x + normal.y[k] * panel.u.y + normal.z[k] * panel.u.z;
      const float v = normal.x[k] * panel.v.x + normal.y[k] * panel.v.y + normal.z[k] * panel.v.z;
      const float highest =
          normal.x[k] * x + normal.y[k] * y + normal.z[k] * z + std::max(u, 0.f) + std::max(v, 0.f);
      hit[k] &= before < 0 && highest > 0 ? -1 : 0;
      any |= hit[k];
    }
    if (!any) return;
    Lanes total{};
    const float cell = 1.f / float(side);
    for (int row = 0; row < side; row++) {
      for (int column = 0; column < side; column++) {
        alignas(64) RTCRay16 shadow;
        alignas(64) int lit[LANES];
        Lanes received;
        int asked = 0;
        for (int k = 0; k < LANES; k++) {
          const float s = (float(column) + offset_u[k]) * cell, t = (float(row) + offset_v[k]) * cell;
          float x = panel.corner.x + s * panel.u.x + t * panel.v.x - point.x[k];
          float y = panel.corner.y + s * panel.u.y + t * panel.v.y - point.y[k];
          float z = panel.corner.z + s * panel.u.z + t * panel.v.z - point.z[k];
          const float square = x * x + y * y + z * z, scale = 1 / std::sqrt(square);
          x *= scale;
          y *= scale;
          z *= scale;
          const float above = normal.x[k] * x + normal.y[k] * y + normal.z[k] * z;
          const float before = -(panel.normal.x * x + panel.normal.y * y + panel.normal.z * z);
          lit[k] = hit[k] & (above > 0 && before > 0 ? -1 : 0);
          asked |= lit[k];
          received[k] = above * before * scale * scale;
          set_shadow_ray(shadow, k, {point.x[k], point.y[k], point.z[k]}, {x, y, z}, square * scale * WAY);
        }
        if (!asked) continue;
        find_occluded(lit, scene, shadow, Rays::COHERENT);
        for (int k = 0; k < LANES; k++) total[k] += lit[k] && shadow.tfar[k] >= 0 ? received[k] : 0.f;
      }
    }
    const float weight = area * cell * cell;
    for (int k = 0; k < LANES; k++) {
      if (!hit[k]) continue;
      sum.x[k] += weight * total[k] * diffuse.x[k] * panel.luminance.x;
      sum.y[k] += weight * total[k] * diffuse.y[k] * panel.luminance.y;
      sum.z[k] += weight * total[k] * diffuse.z[k] * panel.luminance.z;
    }
  }

  Camera camera;
  Panel panel;
  float area;
  std::vector<Part> parts;
  std::vector<Place> places;
  RTCDevice device;
  RTCScene scene;
  Image image;
};

}  // namespace

int main(int count, char** arguments) try {
  if (count != 3) throw std::runtime_error("usage: panel SCENE.bin BUILD_THREADS");
  Renderer renderer(arguments[1], std::atoi(arguments[2]));
  std::cout << renderer.ready() << std::endl;
  std::string command;
  while (std::cin >> command) {
    if (command == "save") {
      std::string path;
      std::getline(std::cin >> std::ws, path);
      renderer.save(path);
      std::cout << "saved" << std::endl;
    } else if (command == "render") {
      int samples, threads, side;
      std::string points;
      if (!(std::cin >> samples >> threads >> side >> points)) throw std::runtime_error("render: something is missing");
      const std::clock_t start = std::clock();
      const double seconds = renderer.render(samples, threads, side, points == "spread");
      std::cout << seconds << " " << double(std::clock() - start) / CLOCKS_PER_SEC << std::endl;
    } else {
      throw std::runtime_error("no such command: " + command);
    }
  }
} catch (const std::exception& error) {
  std::cerr << "panel: " << error.what() << std::endl;
  return 1;
}
