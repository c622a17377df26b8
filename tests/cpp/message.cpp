// SPDX-License-Identifier: GPL-2.0-or-later
// Parts of a message of many types become one text.
#include "mpm/base/require.hpp"

#include <gtest/gtest.h>

using namespace mpm;

TEST(message, joins_text_and_numbers) {
    const std::string name = "soil";
    const char* const unit = "kPa";
    EXPECT_EQ(message("body '", name, "': ", 3, " of ", size_t(7), ", ", 0.1 + 0.2, ' ', unit, "; ", true),
              "body 'soil': 3 of 7, 0.3 kPa; 1");
    EXPECT_EQ(message(), "");
}

TEST(message, shows_NUL_as_two_characters) { EXPECT_EQ(message(std::string("a\0b", 3)), "a\\0b"); }

TEST(require, throws_what_it_was_given_and_only_where_it_does_not_hold) {
    EXPECT_NO_THROW(require(true, "no"));
    try {
        require(false, "count = ", -1, "; give ", 1.5);
        FAIL();
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), "count = -1; give 1.5");
    }
}
