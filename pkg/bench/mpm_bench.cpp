// SPDX-License-Identifier: GPL-2.0-or-later
// The benchmark: what a step costs, stage by stage, without Python. scripts/bench.py makes a table of it;
// alone:
//
//     GOMP_SPINCOUNT=2000 mpm_bench --benchmark_filter='2D/ugimp/.*/20000/threads:1/' --benchmark_repetitions=8
//
// A repetition is a fixed number of steps, part of the name. Minimum and maximum over the repetitions are the
// figures to look at. Needs nothing but the run-time libraries of the compiler, and libbenchmark beside it if
// that is a shared one; for a machine of another kind build with -DMPM_NATIVE=OFF.
#include "bench/soilBlock.hpp"
#include "bench/yardstick.hpp"

#include <algorithm>
#include <benchmark/benchmark.h>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <omp.h>

namespace mpm {

namespace {

using Clock = std::chrono::steady_clock;
constexpr double forever = std::numeric_limits<double>::infinity();
constexpr long particleSteps = 2000000; // of one repetition, so that each takes about as long,
constexpr long leastSteps = 20;         // but so many steps at least

struct Case {
    int dim;
    std::string type, material;
    int particles, threads;
};

// Notes the shortest of many single steps, stage by stage: what other jobs on the machine do to the mean of a
// step, they do not do to every step. It is the last engine.
class Stopwatch : public EngineOf<Stopwatch> {
  public:
    std::vector<double> shortest; // s, of each stage
    double outside = forever;     // s, the shortest time of a step outside of the engines

    std::string className() const override { return "Stopwatch"; }
    std::string doc() const override { return "Notes the shortest time that each stage took."; }
    bool isStage() const override { return false; }

    void restart() {
        shortest.clear();
        outside = forever;
    }

    template <int Dim> void act(Scene<Dim>& scene) {
        double rest = std::chrono::duration<double>(Clock::now() - last_).count();
        const size_t stages = scene.engines.size() - 1;
        const bool isFirst = shortest.empty();
        shortest.resize(stages, forever);
        before_.resize(stages);
        for (size_t e = 0; e < stages; ++e) {
            const double seconds = scene.engines[e]->seconds - before_[e];
            if (!isFirst) shortest[e] = std::min(shortest[e], seconds);
            before_[e] = scene.engines[e]->seconds;
            rest -= seconds;
        }
        if (!isFirst) outside = std::min(outside, rest);
        last_ = Clock::now();
    }

  private:
    std::vector<double> before_; // s, of each stage up to the last step
    Clock::time_point last_;
};

// The scene measured last: repetitions, and the same block on another number of threads, go on with it.
template <int Dim> Scene<Dim>& sceneOf(const Case& c) {
    static std::unique_ptr<Scene<Dim>> scene;
    static std::string made;
    const std::string wanted = message(c.type, c.material, c.particles);
    if (made != wanted) {
        made.clear();
        scene.reset(); // before the next one is made, or both would take memory
        scene = soilBlock<Dim>(c.type, c.material == "mcdp" ? "MohrCoulombDruckerPrager" : "LinearElastic",
                               c.particles);
        scene->engines.push_back(std::make_shared<Stopwatch>());
        made = wanted;
    }
    scene->threads = c.threads;
    return *scene;
}

// Plastic shear strain of all particles by body and id; empty for a material that has none.
template <int Dim> std::vector<double> plasticStrain(const Scene<Dim>& scene) {
    std::vector<double> strain;
    for (auto& body : scene.bodies)
        for (const Field& field : body->particles.state) {
            if (field.name != "plasticShearStrain") continue;
            const size_t first = strain.size();
            strain.resize(first + field.size());
            for (int p = 0; p < field.size(); ++p)
                strain[first + body->particles.id.integers()[p]] = field.plane()[p];
        }
    return strain;
}

double shareThatGrew(const std::vector<double>& before, const std::vector<double>& after) {
    double grew = 0;
    for (size_t p = 0; p < after.size(); ++p) grew += after[p] > before[p];
    return after.empty() ? 0 : grew / double(after.size());
}

template <int Dim> double bytesPerParticle(const Scene<Dim>& scene) {
    double bytes = 0;
    for (auto& body : scene.bodies) bytes += double(body->particles.bytes() + body->domains->bytes());
    return bytes / scene.particleCount();
}

// Since the scene was made.
template <int Dim> ThreadUse threadUse(const Scene<Dim>& scene) {
    ThreadUse all;
    for (auto& engine : scene.engines) {
        all.alone += engine->use.alone;
        all.busy += engine->use.busy;
    }
    return all;
}

// In ns per particle-step: the shortest of each stage and their sum, and the mean step; overhead, the time of
// a step outside of the engines, in us per step; alone, the share of the work that one thread does while others wait.
template <int Dim> void measure(benchmark::State& state, const Case& c) {
    Scene<Dim>& scene = sceneOf<Dim>(c);
    scene.advance(3, forever); // memory is touched, threads are there
    const auto steps = state.max_iterations;
    const auto strain = plasticStrain(scene);
    auto& stopwatch = static_cast<Stopwatch&>(*scene.engines.back());
    stopwatch.restart();
    const ThreadUse before = threadUse(scene);
    const auto start = Clock::now();
    while (state.KeepRunningBatch(steps)) scene.advance(steps, forever);
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();

    const ThreadUse now = threadUse(scene);
    const double alone = now.alone - before.alone, busy = now.busy - before.busy;
    const double perParticle = 1e9 / scene.particleCount();
    double shortest = 0;
    for (size_t e = 0; e < stopwatch.shortest.size(); ++e) {
        state.counters[scene.engines[e]->className()] = stopwatch.shortest[e] * perParticle;
        shortest += stopwatch.shortest[e];
    }
    state.counters["shortest"] = shortest * perParticle;
    state.counters["step"] = seconds / double(steps) * perParticle;
    state.counters["overhead"] = 1e6 * stopwatch.outside;
    state.counters["alone"] = busy > 0 ? alone / (alone + busy) : 0;
    state.counters["particles"] = scene.particleCount();
    state.counters["bytesPerParticle"] = bytesPerParticle(scene);
    state.counters["yielding"] = shareThatGrew(strain, plasticStrain(scene));
}

// Adds the minimum and the maximum over the repetitions.
benchmark::internal::Benchmark* withExtremes(benchmark::internal::Benchmark* benchmark) {
    return benchmark
        ->ComputeStatistics(
            "min", [](const std::vector<double>& v) { return *std::min_element(v.begin(), v.end()); })
        ->ComputeStatistics(
            "max", [](const std::vector<double>& v) { return *std::max_element(v.begin(), v.end()); });
}

void registerCase(const Case& c) {
    const std::string name =
        message(c.dim, "D/", c.type, "/", c.material, "/", c.particles, "/threads:", c.threads);
    const auto run = [c](benchmark::State& state) {
        try {
            c.dim == 2 ? measure<2>(state, c) : measure<3>(state, c);
        } catch (const std::exception& error) {
            state.SkipWithError(error.what());
        }
    };
    withExtremes(benchmark::RegisterBenchmark(name.c_str(), run))
        ->Iterations(std::max(leastSteps, particleSteps / c.particles))
        ->Unit(benchmark::kMicrosecond);
}

// The machine's own measure: ns per particle-step of a bare kernel on one thread.
void registerYardstick() {
    const auto run = [](benchmark::State& state) {
        static Yardstick block(71);
        const double momentum = block.momentum();
        double shortest = forever, sum = 0;
        for (auto _ : state) {
            const auto start = Clock::now();
            block.step();
            const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
            shortest = std::min(shortest, seconds);
            sum += seconds;
        }
        state.counters["shortest"] = 1e9 * shortest / block.particles();
        state.counters["step"] = 1e9 * sum / (double(state.iterations()) * block.particles());
        state.counters["particles"] = block.particles();
        if (std::abs(block.momentum() / momentum - 1) > 1e-9)
            state.SkipWithError("the yardstick loses momentum");
    };
    withExtremes(benchmark::RegisterBenchmark("yardstick", run))->Iterations(particleSteps / 20000);
}

std::string processor() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.rfind("model name", 0) == 0) return line.substr(line.find(": ") + 2);
    return "unknown";
}

std::string environment(const char* name) {
    const char* value = std::getenv(name);
    return value ? value : "";
}

} // namespace

} // namespace mpm

int main(int argc, char** argv) {
    using namespace mpm;
    for (int dim : {2, 3})
        for (int particles : {2000, 20000, 200000, 2000000})
            for (const char* type : {"ugimp", "apdi", "hybrid"})
                for (const char* material : {"elastic", "mcdp"})
                    for (int threads = 1; threads <= omp_get_num_procs(); ++threads)
                        registerCase({dim, type, material, particles, threads});
    registerYardstick();
    benchmark::AddCustomContext("processor", processor());
    benchmark::AddCustomContext("compiler", "gcc " __VERSION__);
    benchmark::AddCustomContext("flags", MPM_FLAGS);
    for (const char* name : {"GOMP_SPINCOUNT", "OMP_WAIT_POLICY"})
        benchmark::AddCustomContext(name, environment(name));
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
}
