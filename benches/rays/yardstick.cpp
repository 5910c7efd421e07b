// The yardstick of rays: Embree 3 or 4 on the same bundle of incoherent rays and segments, one thread.
//
//   yardstick BUNDLE.bin
//
// BUNDLE.bin is what benches/rays/mod.rs writes: 32-bit numbers in the machine's byte order. Rays go 16 at a time
// in the order of the file, without a hint that they be coherent. The program prints `ready MAJOR.MINOR.PATCH`,
// then obeys a command in each line of its input and answers each with one line:
//
//   nearest      rtcIntersect16 for all rays; answers the seconds
//   occluded     rtcOccluded16 for all segments; answers the seconds
//   nearest1     rtcIntersect1 for all rays, one by one; answers the seconds
//   occluded1    rtcOccluded1 for all segments, one by one; answers the seconds
//   save FILE    write the last t of each ray, infinite without a hit, and 1 or 0 for each segment that is
//                occluded or not, as f32
#include "../embree/embree.h"

#include <pmmintrin.h>
#include <time.h>
#include <xmmintrin.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

constexpr int LANES = 16;
constexpr float FAR = std::numeric_limits<float>::infinity();

struct Ray {
  float origin[3], direction[3];
};

template <class T>
std::vector<T> read_list(std::ifstream& file) {
  uint32_t count = 0;
  file.read(reinterpret_cast<char*>(&count), sizeof count);
  std::vector<T> values(count);
  file.read(reinterpret_cast<char*>(values.data()), std::streamsize(count * sizeof(T)));
  if (!file) throw std::runtime_error("the bundle ends early");
  return values;
}

struct Triangle {
  float corners[9];
};

struct Sphere {
  float center_and_radius[4];
};

// Seconds that this thread has had of a processor: another program that runs meanwhile makes no difference.
double processor_time() {
#ifdef __unix__
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return double(time.tv_sec) + double(time.tv_nsec) * 1e-9;
#else
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
#endif
}

class Tracer {
 public:
  explicit Tracer(const char* path) {
    std::ifstream file(path, std::ios::binary);
    const auto triangles = read_list<Triangle>(file);
    const auto spheres = read_list<Sphere>(file);
    rays = read_list<Ray>(file);
    segments = read_list<Ray>(file);
    t.assign(rays.size(), FAR);
    dark.assign(segments.size(), 0);
    // frequency_level: Embree would otherwise keep to 256 bits where 512 could lower the clock.
    device = rtcNewDevice("frequency_level=simd512");
    scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    if (!triangles.empty()) {
      RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
      const size_t count = triangles.size();
      std::memcpy(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * count),
                  triangles.data(), 36 * count);
      auto* corners = static_cast<uint32_t*>(
          rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count));
      for (size_t corner = 0; corner < 3 * count; corner++) corners[corner] = uint32_t(corner);
      attach(mesh);
    }
    if (!spheres.empty()) {
      RTCGeometry balls = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
      std::memcpy(
          rtcSetNewGeometryBuffer(balls, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 16, spheres.size()),
          spheres.data(), 16 * spheres.size());
      attach(balls);
    }
    rtcCommitScene(scene);
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) throw std::runtime_error("Embree reports an error");
  }

  double nearest() {
    const double start = processor_time();
    for (size_t first = 0; first < rays.size(); first += LANES) {
      alignas(64) RTCRayHit16 packet;
      alignas(64) int valid[LANES];
      load(rays, first, FAR, packet.ray, valid);
      for (int k = 0; k < LANES; k++) packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
      find_nearest(valid, scene, packet, Rays::INCOHERENT);
      for (int k = 0; k < LANES; k++)
        if (valid[k]) t[first + k] = packet.ray.tfar[k];
    }
    return processor_time() - start;
  }

  double occluded() {
    const double start = processor_time();
    for (size_t first = 0; first < segments.size(); first += LANES) {
      alignas(64) RTCRay16 packet;
      alignas(64) int valid[LANES];
      load(segments, first, 1, packet, valid);
      find_occluded(valid, scene, packet, Rays::INCOHERENT);
      for (int k = 0; k < LANES; k++)
        if (valid[k]) dark[first + k] = packet.tfar[k] < 0;
    }
    return processor_time() - start;
  }

  double nearest1() {
    const double start = processor_time();
    for (size_t k = 0; k < rays.size(); k++) {
      RTCRayHit ray;
      ray.ray = single(rays[k], FAR);
      ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      find_nearest(scene, ray, Rays::INCOHERENT);
      t[k] = ray.ray.tfar;
    }
    return processor_time() - start;
  }

  double occluded1() {
    const double start = processor_time();
    for (size_t k = 0; k < segments.size(); k++) {
      RTCRay ray = single(segments[k], 1);
      find_occluded(scene, ray, Rays::INCOHERENT);
      dark[k] = ray.tfar < 0;
    }
    return processor_time() - start;
  }

  void save(const std::string& path) const {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(t.data()), std::streamsize(t.size() * 4));
    file.write(reinterpret_cast<const char*>(dark.data()), std::streamsize(dark.size() * 4));
    if (!file) throw std::runtime_error("cannot write " + path);
  }

  std::string ready() const {
    auto property = [&](RTCDeviceProperty name) { return std::to_string(rtcGetDeviceProperty(device, name)); };
    return "ready " + property(RTC_DEVICE_PROPERTY_VERSION_MAJOR) + "." +
           property(RTC_DEVICE_PROPERTY_VERSION_MINOR) + "." + property(RTC_DEVICE_PROPERTY_VERSION_PATCH);
  }

 private:
  static RTCRay single(const Ray& from, float far) {
    RTCRay ray{};
    ray.org_x = from.origin[0], ray.org_y = from.origin[1], ray.org_z = from.origin[2];
    ray.dir_x = from.direction[0], ray.dir_y = from.direction[1], ray.dir_z = from.direction[2];
    ray.tfar = far;
    ray.mask = ~0u;
    return ray;
  }

  void attach(RTCGeometry geometry) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }

  static void load(const std::vector<Ray>& rays, size_t first, float far, RTCRay16& packet, int* valid) {
    for (int k = 0; k < LANES; k++) {
      valid[k] = first + k < rays.size() ? -1 : 0;
      const Ray& ray = rays[valid[k] ? first + k : first];
      packet.org_x[k] = ray.origin[0];
      packet.org_y[k] = ray.origin[1];
      packet.org_z[k] = ray.origin[2];
      packet.dir_x[k] = ray.direction[0];
      packet.dir_y[k] = ray.direction[1];
      packet.dir_z[k] = ray.direction[2];
      packet.tnear[k] = 0;
      packet.tfar[k] = far;
      packet.time[k] = 0;
      packet.mask[k] = ~0u;
      packet.flags[k] = 0;
    }
  }

  RTCDevice device;
  RTCScene scene;
  std::vector<Ray> rays, segments;
  std::vector<float> t, dark;
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) throw std::runtime_error("usage: yardstick BUNDLE.bin");
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
  Tracer tracer(argv[1]);
  std::cout << tracer.ready() << std::endl;
  for (std::string command; std::cin >> command;) {
    if (command == "nearest") {
      std::cout << tracer.nearest() << std::endl;
    } else if (command == "occluded") {
      std::cout << tracer.occluded() << std::endl;
    } else if (command == "nearest1") {
      std::cout << tracer.nearest1() << std::endl;
    } else if (command == "occluded1") {
      std::cout << tracer.occluded1() << std::endl;
    } else if (command == "save") {
      std::string path;
      std::cin >> path;
      tracer.save(path);
      std::cout << "saved" << std::endl;
    } else {
      throw std::runtime_error("unknown command " + command);
    }
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "yardstick: %s\n", error.what());
  return 1;
}
