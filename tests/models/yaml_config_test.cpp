#include "models/yaml_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "message_of.h"
#include "models/errors.h"
#include "models/random.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Part {
  std::string name;
  double angle = 0.0;

  void visit(ConfigVisitor& visitor) {
    visitor.text("name", name, Presence::kRequired);
    visitor.number("angle_deg", angle, {-180.0, 180.0, kDegree});
  }
};

struct Config {
  double length = 0.5;
  double mass = 1.0;
  std::int64_t count = 3;
  bool enabled = false;
  std::string mode = "fast";
  std::string title = "untitled";
  std::vector<double> weights;
  std::vector<std::string> labels;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Interval range{1.0, 2.0};
  double depth = 0.25;
  std::vector<Part> parts;

  void visit(ConfigVisitor& visitor) {
    visitor.number("length_mm", length, {0.0, 1000.0, kMillimetre}, Presence::kRequired);
    visitor.number("mass", mass, {0.1, 10.0, 1.0});
    visitor.integer("count", count, 1, 100);
    visitor.boolean("enabled", enabled);
    visitor.choice("mode", mode, {"fast", "exact"});
    visitor.text("title", title);
    visitor.numbers("weights", weights, 0);
    visitor.texts("labels", labels);
    visitor.vector("position", position);
    visitor.interval("range", range);
    visitor.group("camera", [&](ConfigVisitor& camera) { camera.number("depth", depth); });
    visitor.elements("parts", parts);
  }
};

Config read(const std::string& text) {
  Config config;
  read_yaml_text(text, "c.yaml", [&](ConfigVisitor& visitor) { config.visit(visitor); });
  return config;
}

std::string refusal(const std::string& text) {
  return message_of<InputError>([&] { static_cast<void>(read(text)); });
}

TEST(YamlConfig, ReadsEveryKindOfFieldIntoSi) {
  const Config config = read(
      "length_mm: 250\nmass: +2.5e0\ncount: 7\nenabled: on\nmode: exact\ntitle: 'a: b'\n"
      "weights: [1, 2.5]\nlabels: [x, y]\nposition: [1, 2, 3]\nrange: [0.5, 0.75]\n"
      "camera: {depth: 2}\nparts:\n  - {name: p, angle_deg: 90}\n  - name: q\n");
  EXPECT_DOUBLE_EQ(config.length, 0.25);
  EXPECT_EQ(config.mass, 2.5);
  EXPECT_EQ(config.count, 7);
  EXPECT_TRUE(config.enabled);
  EXPECT_EQ(config.mode, "exact");
  EXPECT_EQ(config.title, "a: b");
  EXPECT_THAT(config.weights, ElementsAre(1.0, 2.5));
  EXPECT_THAT(config.labels, ElementsAre("x", "y"));
  EXPECT_EQ(config.position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(config.range.high, 0.75);
  EXPECT_EQ(config.depth, 2.0);
  ASSERT_EQ(config.parts.size(), 2u);
  EXPECT_DOUBLE_EQ(config.parts[0].angle, M_PI / 2);
  EXPECT_EQ(config.parts[1].name, "q");
}

TEST(YamlConfig, WhatTheFileLeavesOutKeepsItsValue) {
  const Config config = read("length_mm: 1\n");
  EXPECT_EQ(config.mass, 1.0);
  EXPECT_EQ(config.mode, "fast");
  EXPECT_EQ(config.depth, 0.25);
}

TEST(YamlConfig, EachMistakeIsNamedWithItsPlace) {
  EXPECT_THAT(refusal("length_mm: 1\nmas: 2\n"), HasSubstr("c.yaml:2:1: unknown key 'mas'"));
  EXPECT_THAT(refusal("length_mm: 1\nmass: 2\nmass: 3\n"), HasSubstr("c.yaml:3:1: "));
  EXPECT_THAT(refusal("length_mm: 1\nmass: heavy\n"), HasSubstr("c.yaml:2:7: "));
  EXPECT_THAT(refusal("length_mm: 1\nmass: [1]\n"), HasSubstr("c.yaml:2:7: "));
  EXPECT_THAT(refusal("length_mm: 1\nmass: 99\n"), AllOf(HasSubstr("2:7"), HasSubstr("outside")));
  EXPECT_THAT(refusal("length_mm: 2000\n"), HasSubstr("outside"));
  for (const char* number : {".nan", "nan", ".inf", "inf", "1e999", "0x10", "1,5", "1 m", "''"}) {
    EXPECT_THAT(refusal(std::string("length_mm: 1\nmass: ") + number + "\n"), HasSubstr("2:7"))
        << number;
  }
  EXPECT_THAT(refusal("length_mm: 1\ncount: 2.5\n"), HasSubstr("2:8"));
  EXPECT_THAT(refusal("length_mm: 1\ncount: 101\n"), HasSubstr("2:8"));
  EXPECT_THAT(refusal("length_mm: 1\nenabled: maybe\n"), HasSubstr("2:10"));
  EXPECT_THAT(refusal("length_mm: 1\nmode: slow\n"), HasSubstr("fast, exact"));
  EXPECT_THAT(refusal("length_mm: 1\nposition: [1, 2]\n"), HasSubstr("3 numbers"));
  EXPECT_THAT(refusal("length_mm: 1\nrange: [2, 1]\n"), HasSubstr("low <= high"));
  EXPECT_THAT(refusal("length_mm: 1\ncamera: 3\n"), HasSubstr("mapping"));
  EXPECT_THAT(refusal("length_mm: 1\nparts: {name: a}\n"), HasSubstr("list"));
  EXPECT_THAT(refusal("length_mm: 1\nmass:\n"), HasSubstr("no value"));
  EXPECT_THAT(refusal("mass: 1\n"), HasSubstr("'length_mm' is missing"));
  EXPECT_THAT(refusal("length_mm: 1\nparts: [{angle_deg: 3}]\n"),
              HasSubstr("'parts[0].name' is missing"));
}

TEST(YamlConfig, AnchorsDocumentsAndTextsThatAreNoYamlAreRefused) {
  EXPECT_THAT(refusal("length_mm: &a 1\nmass: *a\n"), HasSubstr("c.yaml:1:12: "));
  EXPECT_THAT(refusal("length_mm: 1\n---\nlength_mm: 2\n"), HasSubstr("c.yaml:"));
  EXPECT_THAT(refusal("length_mm: [1\n"), HasSubstr("c.yaml:"));
  EXPECT_THAT(refusal("- 1\n"), HasSubstr("c.yaml:1:1"));
  EXPECT_THAT(refusal(""), HasSubstr("c.yaml"));
}

TEST(YamlConfig, AllProblemsComeAtOnce) {
  const std::string message = refusal("mass: heavy\ncount: 0\nparts: [{nam: x}]\nextra: 1\n");
  EXPECT_GE(std::count(message.begin(), message.end(), '\n'), 5);
  EXPECT_THAT(message, AllOf(HasSubstr("'length_mm' is missing"), HasSubstr("c.yaml:1:7"),
                             HasSubstr("c.yaml:2:8"), HasSubstr("'parts[0].name' is missing"),
                             HasSubstr("'parts[0].nam'"), HasSubstr("'extra'")));
}

TEST(YamlConfig, DeepNestingIsRefused) {
  std::string text = "length_mm: ";
  for (int i = 0; i < 100000; ++i) text += "[";
  EXPECT_THAT(refusal(text), HasSubstr("c.yaml"));
}

// Values as a file can state them: not every number of SI units is a double times the unit.
TEST(YamlConfig, WrittenConfigsReadBackBitForBit) {
  Random random(13);
  for (int trial = 0; trial < 200; ++trial) {
    Config config;
    config.length = random.uniform(0.0, 1000.0) * kMillimetre;
    config.mass = random.uniform(0.1, 10.0);
    config.count = static_cast<std::int64_t>(1 + random.index(100));
    config.enabled = random.index(2) == 0;
    config.title = std::string(trial % 2 == 0 ? "plain" : "a: 'b' # \"c\" [d]");
    for (std::uint64_t i = random.index(4); i > 0; --i) {
      config.weights.push_back(random.normal() * 1e-7);
      config.labels.push_back(std::string("label ").append(std::to_string(i)));
    }
    config.position = random.unit_vector();
    config.range = {random.uniform(), 1.0 + random.uniform()};
    config.parts.resize(random.index(3));
    for (Part& part : config.parts) {
      part.name = std::string(3, static_cast<char>(97 + random.index(26)));
      part.angle = random.uniform(-180.0, 180.0) * kDegree;
    }
    const std::string text = write_yaml([&](ConfigVisitor& visitor) { config.visit(visitor); });
    Config back = read(text);
    EXPECT_EQ(write_yaml([&](ConfigVisitor& visitor) { back.visit(visitor); }), text);
    EXPECT_EQ(back.length, config.length);
    EXPECT_EQ(back.mass, config.mass);
    EXPECT_EQ(back.title, config.title);
    EXPECT_EQ(back.weights, config.weights);
    EXPECT_EQ(back.labels, config.labels);
    EXPECT_EQ(back.position, config.position);
    ASSERT_EQ(back.parts.size(), config.parts.size());
    for (std::size_t i = 0; i < back.parts.size(); ++i) {
      EXPECT_EQ(back.parts[i].angle, config.parts[i].angle);
    }
  }
}

TEST(YamlConfig, AMissingFileIsNamed) {
  EXPECT_THAT(message_of<InputError>([] { read_yaml("/nowhere/c.yaml", [](ConfigVisitor&) {}); }),
              HasSubstr("/nowhere/c.yaml"));
}

TEST(YamlConfig, ABrokenTextWithDocumentsWithoutEndIsRefused) {
  // Found by fuzzing: yaml-cpp reads one empty document after the other here and never ends.
  EXPECT_THAT(message_of<InputError>([] {
                read_yaml_text("#\n  , model: bottle\n    count: 2\n  - model: amicelli\n",
                               "endless", [](ConfigVisitor&) {});
              }),
              HasSubstr("one YAML document"));
}

}  // namespace
}  // namespace binpick
