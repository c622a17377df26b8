// SPDX-License-Identifier: GPL-2.0-or-later
// What is left of memory, by what Linux says of the system and of the groups that a process is in.
#include "mpm/base/freeMemory.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

using namespace mpm;

namespace {

constexpr double GiB = 1 << 30;

// Files as the system shows them, in a folder of its own.
class FreeMemory : public testing::Test {
  protected:
    void SetUp() override {
        std::string name = (std::filesystem::temp_directory_path() / "freeMemoryXXXXXX").string();
        root = mkdtemp(name.data());
        write("/proc/meminfo", "MemTotal:  16777216 kB\nMemFree:  1048576 kB\nMemAvailable:  8388608 kB\n"
                               "SwapFree:  1048576 kB\n");
    }
    void TearDown() override { std::filesystem::remove_all(root); }

    void write(const std::string& path, const std::string& text) {
        std::filesystem::create_directories(std::filesystem::path(root + path).parent_path());
        std::ofstream(root + path) << text;
    }

    std::string root;
};

TEST_F(FreeMemory, is_what_the_system_has_left_with_swap) { EXPECT_EQ(freeMemory(root), 9 * GiB); }

TEST_F(FreeMemory, is_unlimited_where_nobody_says) {
    EXPECT_EQ(freeMemory(root + "/elsewhere"), std::numeric_limits<double>::infinity());
}

TEST_F(FreeMemory, is_what_a_group_or_one_around_it_leaves) {
    write("/proc/self/cgroup", "0::/jobs/mine\n");
    write("/sys/fs/cgroup/jobs/mine/memory.max", "max\n");
    EXPECT_EQ(freeMemory(root), 9 * GiB);
    write("/sys/fs/cgroup/jobs/memory.max", "4294967296\n");
    write("/sys/fs/cgroup/jobs/memory.current", "3221225472\n");
    EXPECT_EQ(freeMemory(root), 1 * GiB);
    write("/sys/fs/cgroup/jobs/memory.stat", "anon 1\ninactive_file 1073741824\nfile 2\n");
    EXPECT_EQ(freeMemory(root), 2 * GiB); // pages of files give way
}

TEST_F(FreeMemory, of_the_first_version_of_groups_too) {
    write("/proc/self/cgroup", "4:cpu,cpuacct:/\n3:memory:/of/the/host\n0::/\n");
    write("/sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
    write("/sys/fs/cgroup/memory/memory.usage_in_bytes", "1073741824\n");
    EXPECT_EQ(freeMemory(root), 9 * GiB);
    write("/sys/fs/cgroup/memory/memory.limit_in_bytes", "4294967296\n"); // a container sees its own as all
    EXPECT_EQ(freeMemory(root), 3 * GiB);
    write("/sys/fs/cgroup/memory/memory.usage_in_bytes", "5368709120\n");
    EXPECT_EQ(freeMemory(root), 0);
}

TEST_F(FreeMemory, is_not_asked_for_small_arrays_and_refuses_large_ones) {
    requireMemory(1000, "Scene: a few", "");
    try {
        requireMemory(1e18, "Scene: the nodes", "give a larger cell");
        FAIL();
    } catch (const MemoryError& error) {
        const std::string text = error.what();
        EXPECT_EQ(text.find("Scene: the nodes take 1e+09 GB of memory, and "), 0) << text;
        EXPECT_NE(text.find(" GB are free; give a larger cell"), std::string::npos) << text;
    }
}

} // namespace
