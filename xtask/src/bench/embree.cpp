// The shadow rays of Embree 3 for `cargo xtask bench`: one occlusion ray for every sample that faces the light.
//
// Commands come line by line on standard input; every answer is one line on standard output, "ok" with its numbers or
// "error" with a reason. Times are seconds, wall and CPU. A file holds
//     u32 vertices, triangles; u64 samples, two-sided ranges; f32 offset; u32 0
//     f32 x y z a vertex; u32 a b c a triangle; f32 x y z nx ny nz a sample; u64 first end a range.
// Samples lie on the surface and are moved along their normals by the offset; those in the ranges have no back.

#include <embree3/rtcore.h>
#include <pmmintrin.h>
#include <xmmintrin.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace {

struct Vec3 {
    float x, y, z;
};

float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

struct Sample {
    Vec3 position, normal;
};

struct Light {
    bool is_sun = true;
    Vec3 place{0, 1, 0};  // of a lamp; of a sun the unit vector towards it

    // The direction from a sample (of unit length, for rays) and how far it is; false for samples that look away.
    bool towards(const Sample& sample, Vec3& direction, float& distance) const {
        direction = place;
        distance = std::numeric_limits<float>::infinity();
        if (!is_sun) {
            direction = {place.x - sample.position.x, place.y - sample.position.y, place.z - sample.position.z};
        }
        if (!(dot(direction, sample.normal) > 0)) return false;
        if (!is_sun) {
            distance = std::sqrt(dot(direction, direction));
            const float scale = 1 / distance;
            direction = {direction.x * scale, direction.y * scale, direction.z * scale};
        }
        return true;
    }
};

struct Clock {
    static double read(clockid_t id) {
        timespec time;
        clock_gettime(id, &time);
        return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
    }
    double wall = read(CLOCK_MONOTONIC), cpu = read(CLOCK_PROCESS_CPUTIME_ID);
    std::string seconds() const {
        std::ostringstream text;
        text.precision(9);
        text << read(CLOCK_MONOTONIC) - wall << ' ' << read(CLOCK_PROCESS_CPUTIME_ID) - cpu;
        return text.str();
    }
};

// What Embree itself says it holds, now and at the most.
struct Memory {
    std::atomic<int64_t> bytes{0}, peak{0};
    static bool count(void* self, ssize_t change, bool) {
        Memory& memory = *static_cast<Memory*>(self);
        const int64_t now = memory.bytes += change;
        for (int64_t peak = memory.peak; peak < now && !memory.peak.compare_exchange_weak(peak, now);) continue;
        return true;
    }
};

template <class T>
void read_values(std::ifstream& file, std::vector<T>& values, size_t count, size_t spare = 0) {
    values.clear();
    values.reserve(count + spare);
    values.resize(count);
    file.read(reinterpret_cast<char*>(values.data()), std::streamsize(count * sizeof(T)));
    if (!file) throw std::runtime_error("the file is too short");
}

// One single ray, a packet, and a stream, filled and asked the same way: `set(k, …)`, `ask(count)`, `is_blocked(k)`.
struct Single {
    static constexpr uint32_t size = 1;
    RTCRay ray{};
    void set(uint32_t, const Sample& from, Vec3 direction, float distance) {
        ray.org_x = from.position.x, ray.org_y = from.position.y, ray.org_z = from.position.z;
        ray.dir_x = direction.x, ray.dir_y = direction.y, ray.dir_z = direction.z;
        ray.tnear = 0, ray.tfar = distance, ray.mask = ~0u;
    }
    void ask(RTCScene scene, RTCIntersectContext& context, uint32_t) { rtcOccluded1(scene, &context, &ray); }
    bool is_blocked(uint32_t) const { return ray.tfar < 0; }
};

template <uint32_t N, class Rays, void (*Occluded)(const int*, RTCScene, RTCIntersectContext*, Rays*)>
struct Packet {
    static constexpr uint32_t size = N;
    alignas(64) int valid[N];
    Rays rays{};
    void set(uint32_t k, const Sample& from, Vec3 direction, float distance) {
        rays.org_x[k] = from.position.x, rays.org_y[k] = from.position.y, rays.org_z[k] = from.position.z;
        rays.dir_x[k] = direction.x, rays.dir_y[k] = direction.y, rays.dir_z[k] = direction.z;
        rays.tnear[k] = 0, rays.tfar[k] = distance, rays.mask[k] = ~0u;
    }
    void ask(RTCScene scene, RTCIntersectContext& context, uint32_t count) {
        for (uint32_t k = 0; k < N; ++k) valid[k] = k < count ? -1 : 0;
        Occluded(valid, scene, &context, &rays);
    }
    bool is_blocked(uint32_t k) const { return rays.tfar[k] < 0; }
};

using Packet8 = Packet<8, RTCRay8, rtcOccluded8>;
using Packet16 = Packet<16, RTCRay16, rtcOccluded16>;

struct Stream {
    static constexpr uint32_t size = 1024;
    std::vector<RTCRay> rays = std::vector<RTCRay>(size);
    void set(uint32_t k, const Sample& from, Vec3 direction, float distance) {
        RTCRay& ray = rays[k];
        ray.org_x = from.position.x, ray.org_y = from.position.y, ray.org_z = from.position.z;
        ray.dir_x = direction.x, ray.dir_y = direction.y, ray.dir_z = direction.z;
        ray.tnear = 0, ray.tfar = distance, ray.mask = ~0u, ray.id = 0, ray.flags = 0, ray.time = 0;
    }
    void ask(RTCScene scene, RTCIntersectContext& context, uint32_t count) {
        rtcOccluded1M(scene, &context, rays.data(), count, sizeof(RTCRay));
    }
    bool is_blocked(uint32_t k) const { return rays[k].tfar < 0; }
};

class Program {
public:
    ~Program() { release(); }

    std::string answer(const std::string& line) {
        std::istringstream words(line);
        std::string command;
        words >> command;
        if (command == "load") return load(words);
        if (command == "light") return set_light(words);
        if (command == "build") return build(words);
        if (command == "rays") return trace(words);
        if (command == "answers") return store_answers(words);
        if (command == "memory") return memory();
        throw std::runtime_error("unknown command " + command);
    }

private:
    static constexpr uint64_t kChunk = 8192;

    std::vector<Vec3> vertices_;
    std::vector<uint32_t> indices_;
    std::vector<Sample> surface_, samples_, shuffled_;  // as read; off the surface; in a random order
    std::vector<std::pair<uint64_t, uint64_t>> two_sided_;
    std::vector<uint32_t> order_;
    std::vector<uint8_t> lit_;
    float offset_ = 0;
    Light light_;
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
    bool is_shuffled_ = false;
    Memory memory_;

    void release() {
        if (scene_) rtcReleaseScene(scene_);
        if (device_) rtcReleaseDevice(device_);
        scene_ = nullptr, device_ = nullptr;
    }

    std::string load(std::istringstream& words) {
        std::string path;
        words >> path;
        std::ifstream file(path, std::ios::binary);
        std::vector<uint64_t> counts;
        std::vector<uint32_t> sizes;
        std::vector<float> offset;
        read_values(file, sizes, 2);
        read_values(file, counts, 2);
        read_values(file, offset, 2);
        offset_ = offset[0];
        read_values(file, vertices_, sizes[0], 2);  // Embree reads 16 bytes for the last vertex.
        read_values(file, indices_, 3 * size_t(sizes[1]));
        read_values(file, surface_, counts[0]);
        read_values(file, two_sided_, counts[1]);
        lit_.assign(surface_.size(), 0);
        samples_.clear(), shuffled_.clear(), order_.clear();
        release();
        return "";
    }

    // Two-sided samples are turned to the light, and all moved off the surface, beforehand: this costs the rays nothing.
    std::string set_light(std::istringstream& words) {
        std::string kind;
        words >> kind >> light_.place.x >> light_.place.y >> light_.place.z;
        light_.is_sun = kind == "sun";
        samples_ = surface_;
        for (const auto& [first, end] : two_sided_) {
            for (uint64_t k = first; k < end; ++k) {
                Vec3 direction, &normal = samples_[k].normal;
                float distance;
                if (!light_.towards(samples_[k], direction, distance)) normal = {-normal.x, -normal.y, -normal.z};
            }
        }
        for (Sample& sample : samples_) {
            sample.position.x += offset_ * sample.normal.x;
            sample.position.y += offset_ * sample.normal.y;
            sample.position.z += offset_ * sample.normal.z;
        }
        shuffled_.clear();
        return "";
    }

    std::string build(std::istringstream& words) {
        std::string quality, mode;
        int threads = 1;
        words >> quality >> mode >> threads;
        release();
        memory_.bytes = memory_.peak = 0;
        device_ = rtcNewDevice(("threads=" + std::to_string(threads) + ",set_affinity=0").c_str());
        if (!device_) throw std::runtime_error("no Embree device");
        rtcSetDeviceMemoryMonitorFunction(device_, Memory::count, &memory_);
        const RTCBuildQuality level = quality == "low"    ? RTC_BUILD_QUALITY_LOW
                                      : quality == "high" ? RTC_BUILD_QUALITY_HIGH
                                                          : RTC_BUILD_QUALITY_MEDIUM;
        const Clock clock;
        RTCGeometry mesh = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices_.data(), 0, 12,
                                   vertices_.size());
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices_.data(), 0, 12,
                                   indices_.size() / 3);
        rtcSetGeometryBuildQuality(mesh, level);
        rtcCommitGeometry(mesh);
        scene_ = rtcNewScene(device_);
        rtcSetSceneFlags(scene_, mode == "robust" ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
        rtcSetSceneBuildQuality(scene_, level);
        rtcAttachGeometry(scene_, mesh);
        rtcReleaseGeometry(mesh);
        rtcCommitScene(scene_);
        return clock.seconds();
    }

    std::string trace(std::istringstream& words) {
        std::string kind, order;
        uint32_t threads = 1;
        words >> kind >> order >> threads;
        if (!scene_) throw std::runtime_error("nothing is built");
        is_shuffled_ = order == "shuffled";
        if (is_shuffled_) shuffle();
        if (kind == "single") return run<Single>(threads);
        if (kind == "packet8") return run<Packet8>(threads);
        if (kind == "packet16") return run<Packet16>(threads);
        if (kind == "stream") return run<Stream>(threads);
        throw std::runtime_error("unknown kind of rays " + kind);
    }

    // A fixed permutation (Fisher and Yates; the numbers are those of SplitMix64).
    void shuffle() {
        if (shuffled_.size() == samples_.size()) return;
        order_.resize(samples_.size());
        for (uint64_t k = 0; k < order_.size(); ++k) order_[k] = uint32_t(k);
        uint64_t state = 1;
        for (uint64_t k = order_.size(); k > 1; --k) {
            uint64_t mixed = state += 0x9e3779b97f4a7c15u;
            mixed = (mixed ^ mixed >> 30) * 0xbf58476d1ce4e5b9u;
            mixed = (mixed ^ mixed >> 27) * 0x94d049bb133111ebu;
            std::swap(order_[k - 1], order_[(mixed ^ mixed >> 31) % k]);
        }
        shuffled_.resize(samples_.size());
        for (uint64_t k = 0; k < order_.size(); ++k) shuffled_[k] = samples_[order_[k]];
    }

    template <class Rays>
    std::string run(uint32_t threads) {
        std::atomic<uint64_t> next{0}, traced{0};
        const auto work = [&] {
            // What Embree's manual recommends for its threads.
            _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
            _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
            Rays rays;
            uint64_t own = 0;
            for (uint64_t first; (first = next.fetch_add(kChunk)) < samples_.size();) {
                own += run_chunk(rays, first, std::min<uint64_t>(first + kChunk, samples_.size()));
            }
            traced += own;
        };
        const Clock clock;
        std::vector<std::thread> others;
        for (uint32_t k = 1; k < threads; ++k) others.emplace_back(work);
        work();
        for (std::thread& other : others) other.join();
        std::string seconds = clock.seconds();
        const uint64_t lit = uint64_t(std::count(lit_.begin(), lit_.end(), 1));
        return seconds + ' ' + std::to_string(traced) + ' ' + std::to_string(lit);
    }

    template <class Rays>
    uint64_t run_chunk(Rays& rays, uint64_t first, uint64_t end) {
        const Sample* samples = is_shuffled_ ? shuffled_.data() : samples_.data();
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = is_shuffled_ ? RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT : RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        uint64_t places[Rays::size], traced = 0;
        uint32_t count = 0;
        const auto flush = [&] {
            rays.ask(scene_, context, count);
            for (uint32_t k = 0; k < count; ++k) lit_[places[k]] = !rays.is_blocked(k);
            traced += count;
            count = 0;
        };
        for (uint64_t k = first; k < end; ++k) {
            Vec3 direction;
            float distance;
            if (!light_.towards(samples[k], direction, distance)) {
                lit_[k] = 0;
                continue;
            }
            places[count] = k;
            rays.set(count, samples[k], direction, distance);
            if (++count == Rays::size) flush();
        }
        if (count > 0) flush();
        return traced;
    }

    // One byte a sample, 1 for lit, in the order of the file.
    std::string store_answers(std::istringstream& words) {
        std::string path;
        words >> path;
        std::vector<uint8_t> straight = lit_;
        if (is_shuffled_) {
            for (uint64_t k = 0; k < lit_.size(); ++k) straight[order_[k]] = lit_[k];
        }
        std::ofstream file(path, std::ios::binary);
        file.write(reinterpret_cast<const char*>(straight.data()), std::streamsize(straight.size()));
        if (!file) throw std::runtime_error("cannot write " + path);
        return "";
    }

    // The most that Embree held for the last build, and the answers.
    std::string memory() { return std::to_string(uint64_t(memory_.peak) + lit_.size()); }
};

}  // namespace

int main() {
    Program program;
    for (std::string line; std::getline(std::cin, line);) {
        try {
            std::cout << "ok " << program.answer(line) << std::endl;
        } catch (const std::exception& error) {
            std::cout << "error " << error.what() << std::endl;
        }
    }
}
