// SPDX-License-Identifier: GPL-2.0-or-later
// The benchmark: what a step costs, stage by stage, without Python. scripts/bench.py makes a table of it; alone:
//
//     GOMP_SPINCOUNT=2000 mpm_bench --benchmark_filter='2D/ugimp/.*/20000/threads:1/' --benchmark_repetitions=8
//
// A repetition is a fixed number of steps, part of the name. Minimum and maximum over the repetitions are the figures to
// look at. Needs nothing but the run-time libraries of the compiler, and libbenchmark beside it if that is a shared one;
// for a machine of another kind build with -DMPM_NATIVE=OFF.
#include "bench/soilBlock.hpp"
#include "bench/yardstick.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <omp.h>

namespace mpm {

namespace {

constexpr double forever = std::numeric_limits<double>::infinity();
constexpr long particleSteps = 2000000, leastSteps = 20; // of one repetition

struct Case {
    int dim;
    std::string type, material;
    int particles, threads;
};

// The scene measured last: repetitions, and the same block on another number of threads, go on with it.
template <int Dim> Scene<Dim>& sceneOf(const Case& c) {
    static std::unique_ptr<Scene<Dim>> scene;
    static std::string made;
    const std::string wanted = message(c.type, c.material, c.particles);
    if (made != wanted) {
        made.clear(), scene.reset(); // first, or both would take memory
        scene = soilBlock<Dim>(c.type, c.material == "mcdp" ? "MohrCoulombDruckerPrager" : "LinearElastic", c.particles);
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
            for (int p = 0; p < field.size(); ++p) strain[first + body->particles.id.integers()[p]] = field.plane()[p];
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

template <int Dim> std::vector<double> engineSeconds(const Scene<Dim>& scene) {
    std::vector<double> seconds;
    for (auto& engine : scene.engines) seconds.push_back(engine->seconds);
    return seconds;
}

// Stages and step in ns per particle-step; overhead, the time of a step outside of the engines, in us per step.
template <int Dim> void measure(benchmark::State& state, const Case& c) {
    Scene<Dim>& scene = sceneOf<Dim>(c);
    scene.advance(3, forever); // memory is touched, threads are there
    const auto steps = state.max_iterations;
    const auto strain = plasticStrain(scene);
    const auto before = engineSeconds(scene);
    const auto start = std::chrono::steady_clock::now();
    while (state.KeepRunningBatch(steps)) scene.advance(steps, forever);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const auto after = engineSeconds(scene);

    const double perParticleStep = 1e9 / (double(steps) * scene.particleCount());
    double outside = seconds;
    for (size_t e = 0; e < after.size(); ++e) {
        state.counters[scene.engines[e]->className()] = (after[e] - before[e]) * perParticleStep;
        outside -= after[e] - before[e];
    }
    state.counters["step"] = seconds * perParticleStep;
    state.counters["overhead"] = 1e6 * outside / double(steps);
    state.counters["particles"] = scene.particleCount();
    state.counters["bytesPerParticle"] = bytesPerParticle(scene);
    state.counters["yielding"] = shareThatGrew(strain, plasticStrain(scene));
}

void registerCase(const Case& c) {
    const std::string name = message(c.dim, "D/", c.type, "/", c.material, "/", c.particles, "/threads:", c.threads);
    const auto run = [c](benchmark::State& state) {
        try {
            c.dim == 2 ? measure<2>(state, c) : measure<3>(state, c);
        } catch (const std::exception& error) {
            state.SkipWithError(error.what());
        }
    };
    benchmark::RegisterBenchmark(name.c_str(), run)
        ->Iterations(std::max(leastSteps, particleSteps / c.particles))
        ->Unit(benchmark::kMicrosecond)
        ->ComputeStatistics("min", [](const std::vector<double>& v) { return *std::min_element(v.begin(), v.end()); })
        ->ComputeStatistics("max", [](const std::vector<double>& v) { return *std::max_element(v.begin(), v.end()); });
}

// The machine's own measure: ns per particle-step of a bare kernel on one thread.
void registerYardstick() {
    const auto run = [](benchmark::State& state) {
        static Yardstick block(71);
        const double momentum = block.momentum();
        const auto steps = state.max_iterations;
        const auto start = std::chrono::steady_clock::now();
        while (state.KeepRunningBatch(steps))
            for (long i = 0; i < steps; ++i) block.step();
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        state.counters["step"] = 1e9 * seconds / (double(steps) * block.particles());
        state.counters["particles"] = block.particles();
        if (std::abs(block.momentum() / momentum - 1) > 1e-9) state.SkipWithError("the yardstick loses momentum");
    };
    benchmark::RegisterBenchmark("yardstick", run)
        ->Iterations(particleSteps / 20000)
        ->ComputeStatistics("min", [](const std::vector<double>& v) { return *std::min_element(v.begin(), v.end()); })
        ->ComputeStatistics("max", [](const std::vector<double>& v) { return *std::max_element(v.begin(), v.end()); });
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
    for (const char* name : {"GOMP_SPINCOUNT", "OMP_WAIT_POLICY"}) benchmark::AddCustomContext(name, environment(name));
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
}
