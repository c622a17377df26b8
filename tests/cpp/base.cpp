// SPDX-License-Identifier: GPL-2.0-or-later
// Registry and parameters, as seen from C++.
#include "mpm/base/parameters.hpp"
#include "mpm/base/registry.hpp"

#include <gtest/gtest.h>

using namespace mpm;

namespace {

struct Shape {
    virtual ~Shape() = default;
    virtual int sides() const = 0;
};
struct Triangle : Shape {
    int sides() const override { return 3; }
};
struct Square : Shape {
    int sides() const override { return 4; }
};
MPM_REGISTER(Shape, Triangle);
MPM_REGISTER(Shape, Square);

class Anchor : public Configurable {
  public:
    double load = notGiven, angle = 0.5;
    int strands = 1;
    bool isGrouted = false;
    std::string kind = "bar";
    std::vector<double> axis{1, 0};

    std::string className() const override { return "Anchor"; }
    std::vector<Parameter> parameters() override {
        return {{"load", "kN", "Working load.", &load, Range::positive()},
                {"angle", "rad", "Below the horizon.", &angle, Range::inside(0, 1.6), {}, true},
                {"strands", "-", "Number of strands.", &strands, Range::between(1, 12)},
                {"isGrouted", "", "Whether it is grouted.", &isGrouted},
                {"kind", "", "Kind of tendon.", &kind, {}, {"bar", "strand"}},
                {"axis", "-", "Direction.", &axis, Range::any()}};
    }
};

// What set() complains of; empty if it does not.
std::string complaint(const std::string& name, const Value& value) {
    Anchor anchor;
    try {
        anchor.set(name, value);
        return "";
    } catch (const InputError& error) {
        return error.what();
    }
}

void expectIn(const std::string& part, const std::string& text) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in '" << text << "'";
}

} // namespace

TEST(Registry, makes_classes_by_name) {
    EXPECT_EQ(Registry<Shape>::names(), (std::vector<std::string>{"Square", "Triangle"}));
    EXPECT_EQ(Registry<Shape>::make("Triangle")->sides(), 3);
    EXPECT_NE(Registry<Shape>::make("Square"), Registry<Shape>::make("Square"));
    EXPECT_THROW(Registry<Shape>::make("Circle"), InputError);
}

TEST(Registry, takes_no_class_of_a_taken_name_or_of_another_build) {
    const auto make = [] { return std::make_shared<Square>(); };
    EXPECT_FALSE(Registry<Shape>::add("Square", make, MPM_BUILD, sizeof(Shape)));
    EXPECT_FALSE(
        Registry<Shape>::add("Other", make, "yade_mpm 0.0.1, GCC 1, no AVX, Eigen 1.0.0", sizeof(Shape)));
    EXPECT_FALSE(Registry<Shape>::add("Other", make, MPM_BUILD, sizeof(Shape) + 8));
    EXPECT_EQ(Registry<Shape>::names().size(), 2u);
    EXPECT_TRUE(Registry<Shape>::add("Other", make, MPM_BUILD, sizeof(Shape))); // the control
}

TEST(loadPlugin, tells_that_there_is_no_such_file) {
    EXPECT_THROW(loadPlugin("/nowhere/plugin.so"), InputError);
}

TEST(Configurable, keeps_allowed_values) {
    Anchor anchor;
    anchor.set("load", 3); // an int is a number
    anchor.set("strands", 4);
    anchor.set("isGrouted", true);
    anchor.set("kind", std::string("strand"));
    anchor.set("axis", std::vector<double>{0, 1});
    EXPECT_EQ(std::get<double>(anchor.value("load")), 3);
    EXPECT_EQ(std::get<int>(anchor.value("strands")), 4);
    EXPECT_TRUE(std::get<bool>(anchor.value("isGrouted")));
    EXPECT_EQ(std::get<std::string>(anchor.value("kind")), "strand");
    EXPECT_EQ(std::get<std::vector<double>>(anchor.value("axis")), (std::vector<double>{0, 1}));
    anchor.set("axis", 2.0); // a number is a vector of one
    EXPECT_EQ(anchor.axis, std::vector<double>{2});
}

TEST(Configurable, tells_what_is_allowed) {
    expectIn("load = -1 is not allowed; give a positive number (kN)", complaint("load", -1.0));
    expectIn("positive number", complaint("load", 0.0));
    expectIn("positive number", complaint("load", std::nan("")));
    expectIn("positive number", complaint("load", std::string("much")));
    expectIn("angle = 30 is in radians; did you mean radians(30)?", complaint("angle", 30.0));
    expectIn("a whole number", complaint("strands", 1.5));
    expectIn("[1, 12]", complaint("strands", 13));
    expectIn("True or False", complaint("isGrouted", 1));
    expectIn("one of 'bar', 'strand'", complaint("kind", std::string("rope")));
    expectIn("a sequence of numbers", complaint("axis", std::string("x")));
}

TEST(Configurable, finds_what_a_misspelt_name_meant) {
    expectIn("did you mean 'strands'?", complaint("strnads", 1));
    expectIn("did you mean 'isGrouted'?", complaint("isgrouted", true));
    const std::string other = complaint("xyzzy", 1);
    EXPECT_EQ(other.find("did you mean"), std::string::npos);
    expectIn("allowed: 'load', 'angle'", other);
    EXPECT_THROW(Anchor().value("xyzzy"), InputError);
}

TEST(Range, ends_belong_to_it_or_not) {
    EXPECT_FALSE(Range::positive().contains(0));
    EXPECT_TRUE(Range::notNegative().contains(0));
    EXPECT_TRUE(Range::between(1, 2).contains(2));
    EXPECT_FALSE(Range::inside(1, 2).contains(2));
    EXPECT_EQ(Range::inside(1, 2).text(), "a number in (1, 2)");
    EXPECT_EQ(Range::any().text(), "a finite number");
}
