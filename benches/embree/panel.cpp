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
#include "embree.h"

#include <pmmintrin.h>
#include <xmmintrin.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iostream>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace {

constexpr int LANES = 16, PACKET_SIDE = 4, TILE = 16;
constexpr float FAR = std::numeric_limits<float>::max();

// How far shadow rays start from the surface, as a share of the magnitudes that its position was computed from, and
// how far of the way to the panel they go, so that they do not meet it.
constexpr float OFFSET = 1e-6f, WAY = 1 - 1e-4f;

struct Vec3 {
  float x, y, z;
};

struct alignas(64) Lanes {
  float lane[LANES];
  float& operator[](int k) { return lane[k]; }
  float operator[](int k) const { return lane[k]; }
};

struct Lanes3 {
  Lanes x, y, z;
};

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

class Reader {
 public:
  explicit Reader(const char* path) : file(path, std::ios::binary) {}
  template <class T>
  void into(T* target, size_t count) {
    file.read(reinterpret_cast<char*>(target), std::streamsize(count * sizeof(T)));
    if (!file) throw std::runtime_error("the scene file ends early");
  }
  template <class T>
  T one() {
    T value;
    into(&value, 1);
    return value;
  }
  template <class T>
  std::vector<T> list() {
    std::vector<T> values(one<uint32_t>());
    into(values.data(), values.size());
    return values;
  }

 private:
  std::ifstream file;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

float radical_inverse(uint32_t n) {
  float value = 0, digit = .5f;
  for (; n; n >>= 1, digit /= 2) value += float(n & 1) * digit;
  return value;
}

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
    width = reader.one<uint32_t>();
    height = reader.one<uint32_t>();
    camera = reader.one<Camera>();
    panel = reader.one<Panel>();
    const Vec3 u = panel.u, v = panel.v;
    const Vec3 across{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
    area = std::sqrt(across.x * across.x + across.y * across.y + across.z * across.z);
    // frequency_level: Embree would otherwise keep to 256 bits where 512 could lower the clock.
    device = rtcNewDevice(("frequency_level=simd512,threads=" + std::to_string(threads)).c_str());
    scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    parts.resize(reader.one<uint32_t>());
    for (Part& part : parts) {
      part.kind = Part::Kind(reader.one<uint32_t>());
      part.diffuse = reader.one<Vec3>();
      RTCGeometry shapes;
      if (part.kind == Part::SPHERES) {
        shapes = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
        buffer(shapes, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, 16, reader.list<float>());
      } else {
        shapes = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        buffer(shapes, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 12, reader.list<Vec3>());
        buffer(shapes, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 12, reader.list<uint32_t>());
      }
      rtcCommitGeometry(shapes);
      rtcAttachGeometry(scene, shapes);
      rtcReleaseGeometry(shapes);
    }
    rtcCommitScene(scene);
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) throw std::runtime_error("Embree reports an error");
    image.resize(size_t(width) * height);
  }

  double render(int samples, int threads, int side, bool is_spread) {
    const auto start = std::chrono::steady_clock::now();
    if (is_spread) places = multijittered(samples);
    const int columns = (width + TILE - 1) / TILE, rows = (height + TILE - 1) / TILE;
    std::atomic<int> next{0};
    auto work = [&] {
      _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
      _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
      for (int tile; (tile = next++) < columns * rows;) {
        const int left = tile % columns * TILE, top = tile / columns * TILE;
        for (int y = top; y < std::min(height, top + TILE); y += PACKET_SIDE)
          for (int x = left; x < std::min(width, left + TILE); x += PACKET_SIDE)
            is_spread ? pixels<true>(x, y, samples, side) : pixels<false>(x, y, samples, side);
      }
    };
    std::vector<std::thread> pool;
    for (int i = 0; i < threads; i++) pool.emplace_back(work);
    for (std::thread& thread : pool) thread.join();
    return seconds_since(start);
  }

  void save(const std::string& path) const {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(image.data()), std::streamsize(image.size() * sizeof(Vec3)));
    if (!file) throw std::runtime_error("cannot write " + path);
  }

  std::string ready() const {
    auto property = [&](RTCDeviceProperty name) { return std::to_string(rtcGetDeviceProperty(device, name)); };
    return "ready " + property(RTC_DEVICE_PROPERTY_VERSION_MAJOR) + "." +
           property(RTC_DEVICE_PROPERTY_VERSION_MINOR) + "." + property(RTC_DEVICE_PROPERTY_VERSION_PATCH);
  }

 private:
  template <class T>
  void buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, size_t size, const std::vector<T>& values) {
    const size_t bytes = values.size() * sizeof(T);
    std::memcpy(rtcSetNewGeometryBuffer(geometry, type, 0, format, size, bytes / size), values.data(), bytes);
  }

  // All samples of 4 x 4 pixels.
  template <bool SPREAD>
  void pixels(int left, int top, int samples, int side) {
    Lanes3 sum{};
    // Which patterns each pixel's points in their cells and its rays have.
    const Place *pattern[LANES] = {}, *rays[LANES] = {};
    if (SPREAD)
      for (int k = 0; k < LANES; k++) {
        const uint32_t column = uint32_t(left + k % PACKET_SIDE), row = uint32_t(top + k / PACKET_SIDE);
        const uint32_t pixel = scrambled(row * uint32_t(width) + column);
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
        valid[k] = column < width && row < height ? -1 : 0;
        packet.ray.org_x[k] = camera.origin.x;
        packet.ray.org_y[k] = camera.origin.y;
        packet.ray.org_z[k] = camera.origin.z;
        const float u = camera.direction.x + x * camera.direction_x.x + y * camera.direction_y.x;
        const float v = camera.direction.y + x * camera.direction_x.y + y * camera.direction_y.y;
        const float w = camera.direction.z + x * camera.direction_x.z + y * camera.direction_y.z;
        const float scale = 1 / std::sqrt(u * u + v * v + w * w);
        packet.ray.dir_x[k] = u * scale;
        packet.ray.dir_y[k] = v * scale;
        packet.ray.dir_z[k] = w * scale;
        packet.ray.tnear[k] = 0;
        packet.ray.tfar[k] = FAR;
        packet.ray.time[k] = 0;
        packet.ray.mask[k] = ~0u;
        packet.ray.flags[k] = 0;
        packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
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
    for (int k = 0; k < LANES; k++) {
      const int column = left + k % PACKET_SIDE, row = top + k / PACKET_SIDE;
      if (column < width && row < height)
        image[size_t(row) * width + column] = {sum.x[k] / samples, sum.y[k] / samples, sum.z[k] / samples};
    }
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
      const float t = hit[k] ? ray.tfar[k] : 0;
      // Lanes without a hit compute something harmless.
      const float gx = hit[k] ? packet.hit.Ng_x[k] : 1, gy = hit[k] ? packet.hit.Ng_y[k] : 0,
                  gz = hit[k] ? packet.hit.Ng_z[k] : 0;
      const float towards = gx * ray.dir_x[k] + gy * ray.dir_y[k] + gz * ray.dir_z[k];
      const float scale = (towards > 0 ? -1 : 1) / std::sqrt(gx * gx + gy * gy + gz * gz);
      normal.x[k] = gx * scale;
      normal.y[k] = gy * scale;
      normal.z[k] = gz * scale;
      const float x = ray.org_x[k] + t * ray.dir_x[k], y = ray.org_y[k] + t * ray.dir_y[k],
                  z = ray.org_z[k] + t * ray.dir_z[k];
      const float offset = OFFSET * (t + std::abs(x) + std::abs(y) + std::abs(z));
      point.x[k] = x + offset * normal.x[k];
      point.y[k] = y + offset * normal.y[k];
      point.z[k] = z + offset * normal.z[k];
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
          shadow.org_x[k] = point.x[k];
          shadow.org_y[k] = point.y[k];
          shadow.org_z[k] = point.z[k];
          shadow.dir_x[k] = x;
          shadow.dir_y[k] = y;
          shadow.dir_z[k] = z;
          shadow.tnear[k] = 0;
          shadow.tfar[k] = square * scale * WAY;
          shadow.time[k] = 0;
          shadow.mask[k] = ~0u;
          shadow.flags[k] = 0;
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

  int width, height;
  Camera camera;
  Panel panel;
  float area;
  std::vector<Part> parts;
  std::vector<Place> places;
  RTCDevice device;
  RTCScene scene;
  std::vector<Vec3> image;
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
