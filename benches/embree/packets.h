// What the yardsticks of direct light have in common: rays in packets of 16 (4 x 4 pixels), tiles of 16 x 16 pixels that
// threads take from a counter, scene files and images.
#pragma once

#include "embree.h"

#include <pmmintrin.h>
#include <xmmintrin.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

constexpr int LANES = 16, PACKET_SIDE = 4, TILE = 16;
constexpr float FAR = std::numeric_limits<float>::max();

struct Vec3 {
  float x, y, z;
};

// One number for each of 16 rays.
struct alignas(64) Lanes {
  float lane[LANES];
  float& operator[](int k) { return lane[k]; }
  float operator[](int k) const { return lane[k]; }
};

struct Lanes3 {
  Lanes x, y, z;
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

inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

inline float radical_inverse(uint32_t n) {
  float value = 0, digit = .5f;
  for (; n; n >>= 1, digit /= 2) value += float(n & 1) * digit;
  return value;
}

inline RTCDevice new_device(int threads) {
  // frequency_level: Embree would otherwise keep to 256 bits where 512 could lower the clock.
  return rtcNewDevice(("frequency_level=simd512,threads=" + std::to_string(threads)).c_str());
}

inline RTCScene new_scene(RTCDevice device) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  return scene;
}

template <class T>
inline void buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, size_t size,
                   const std::vector<T>& values) {
  const size_t bytes = values.size() * sizeof(T);
  std::memcpy(rtcSetNewGeometryBuffer(geometry, type, 0, format, size, bytes / size), values.data(), bytes);
}

// Centers with their radii.
inline RTCGeometry read_spheres(RTCDevice device, Reader& reader) {
  RTCGeometry spheres = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
  buffer(spheres, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, 16, reader.list<float>());
  return spheres;
}

// Vertices, then three numbers of them for each triangle.
inline RTCGeometry read_triangles(RTCDevice device, Reader& reader) {
  RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  buffer(mesh, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 12, reader.list<Vec3>());
  buffer(mesh, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 12, reader.list<uint32_t>());
  return mesh;
}

// Geometries get numbers in this order.
inline void attach(RTCScene scene, RTCGeometry geometry) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

inline void commit(RTCDevice device, RTCScene scene) {
  rtcCommitScene(scene);
  if (rtcGetDeviceError(device) != RTC_ERROR_NONE) throw std::runtime_error("Embree reports an error");
}

inline std::string version(RTCDevice device) {
  auto property = [&](RTCDeviceProperty name) { return std::to_string(rtcGetDeviceProperty(device, name)); };
  return property(RTC_DEVICE_PROPERTY_VERSION_MAJOR) + "." + property(RTC_DEVICE_PROPERTY_VERSION_MINOR) + "." +
         property(RTC_DEVICE_PROPERTY_VERSION_PATCH);
}

struct Image {
  int width, height;
  std::vector<Vec3> pixels;

  Image() = default;
  Image(int width, int height) : width(width), height(height), pixels(size_t(width) * height) {}

  bool holds(int column, int row) const { return column < width && row < height; }

  // The means of the pixels of a packet that are in the image, from sums over samples.
  void put(int left, int top, const Lanes3& sum, int samples) {
    for (int k = 0; k < LANES; k++) {
      const int column = left + k % PACKET_SIDE, row = top + k / PACKET_SIDE;
      if (holds(column, row))
        pixels[size_t(row) * width + column] = {sum.x[k] / samples, sum.y[k] / samples, sum.z[k] / samples};
    }
  }

  // R, G, B as f32, row by row from the top.
  void save(const std::string& path) const {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(pixels.data()), std::streamsize(pixels.size() * sizeof(Vec3)));
    if (!file) throw std::runtime_error("cannot write " + path);
  }
};

// Calls render_packet(x, y) for each packet of an image, from so many threads.
template <class RenderPacket>
void for_packets(int width, int height, int threads, RenderPacket render_packet) {
  const int columns = (width + TILE - 1) / TILE, rows = (height + TILE - 1) / TILE;
  std::atomic<int> next{0};
  auto work = [&] {
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    for (int tile; (tile = next++) < columns * rows;) {
      const int left = tile % columns * TILE, top = tile / columns * TILE;
      for (int y = top; y < std::min(height, top + TILE); y += PACKET_SIDE)
        for (int x = left; x < std::min(width, left + TILE); x += PACKET_SIDE) render_packet(x, y);
    }
  };
  std::vector<std::thread> pool;
  for (int i = 0; i < threads; i++) pool.emplace_back(work);
  for (std::thread& thread : pool) thread.join();
}

// A camera ray in a lane, with a direction of any length.
inline void set_ray(RTCRayHit16& packet, int k, Vec3 origin, Vec3 direction) {
  const float u = direction.x, v = direction.y, w = direction.z;
  const float scale = 1 / std::sqrt(u * u + v * v + w * w);
  packet.ray.org_x[k] = origin.x;
  packet.ray.org_y[k] = origin.y;
  packet.ray.org_z[k] = origin.z;
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

// A shadow ray in a lane, with a direction of length 1.
inline void set_shadow_ray(RTCRay16& shadow, int k, Vec3 origin, Vec3 direction, float distance) {
  shadow.org_x[k] = origin.x;
  shadow.org_y[k] = origin.y;
  shadow.org_z[k] = origin.z;
  shadow.dir_x[k] = direction.x;
  shadow.dir_y[k] = direction.y;
  shadow.dir_z[k] = direction.z;
  shadow.tnear[k] = 0;
  shadow.tfar[k] = distance;
  shadow.time[k] = 0;
  shadow.mask[k] = ~0u;
  shadow.flags[k] = 0;
}

// Of a lane, the geometric normal towards the viewer, and the point that is hit, `offset` off the surface as a share of
// the magnitudes that it was computed from. A lane without a hit gets something harmless.
inline void find_point(const RTCRayHit16& packet, int k, bool hit, float offset, Lanes3& point, Lanes3& normal) {
  const auto& ray = packet.ray;
  const float t = hit ? ray.tfar[k] : 0;
  const float gx = hit ? packet.hit.Ng_x[k] : 1, gy = hit ? packet.hit.Ng_y[k] : 0, gz = hit ? packet.hit.Ng_z[k] : 0;
  const float towards = gx * ray.dir_x[k] + gy * ray.dir_y[k] + gz * ray.dir_z[k];
  const float scale = (towards > 0 ? -1 : 1) / std::sqrt(gx * gx + gy * gy + gz * gz);
  normal.x[k] = gx * scale;
  normal.y[k] = gy * scale;
  normal.z[k] = gz * scale;
  const float x = ray.org_x[k] + t * ray.dir_x[k], y = ray.org_y[k] + t * ray.dir_y[k],
              z = ray.org_z[k] + t * ray.dir_z[k];
  const float off = offset * (t + std::abs(x) + std::abs(y) + std::abs(z));
  point.x[k] = x + off * normal.x[k];
  point.y[k] = y + off * normal.y[k];
  point.z[k] = z + off * normal.z[k];
}
