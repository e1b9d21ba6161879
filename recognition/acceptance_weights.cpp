// Written by recognition_calibration --scenes 360 --passes 2
// (tests/recognition/acceptance_calibration_main.cpp); not edited by hand.

#include "recognition/acceptance_model.h"

// clang-format off
namespace binpick {

const AcceptanceModel& calibrated_acceptance() {
  static const AcceptanceModel model = {
    .bias = 5.49776,
    // low, high, centre, scale, slope, knots, bends
    .terms = {{
      {4.15888, 9.45203, 6.84162, 0.891874, 1.1924, {-0.639807, 0, 0.66051}, {-0.70693, 0, 0}},
      {-2.87112, 0.196295, -0.639036, 0.60598, 0.563397, {-0.74035, 0, 0.640091}, {-0.526066, -0.0373309, 0.400045}},
      {0.0690846, 0.996425, 0.540049, 0.32065, 0, {-0.603845, 0, 0.981576}, {0, 0.344211, 0.67525}},
      {0, 0.438337, 0.16133, 0.105832, -0.0349479, {-0.704302, 0, 0.671274}, {-0.891514, 0.425872, -0.148382}},
      {0, 0.606199, 0.130221, 0.153664, -0, {-0.526051, 0, 0.962452}, {0, -0.127714, -1.66435}},
      {0, 0.388689, 0.110838, 0.0877165, -0, {-0.677108, 0, 0.700293}, {0, 0, 0}},
      {0, 0.690613, 0.205806, 0.237355, -1.34517, {-0.496298, 0, 1.15652}, {-0.652132, -1.87242, 2.52455}},
      {0, 0.588419, 0, 0.0334975, -0, {0, 0, 0}, {0, 0, -0.117042}},
      {0, 0.642091, 0, 0.138675, -1.76241, {0, 0, 1.07497}, {0, -0.537567, -0.764859}},
      {0, 0.863309, 0.110236, 0.238636, 1.93285, {-0.416883, 0, 1.15769}, {1.83988, -2.26628, 0}},
      {0, 0.538516, 0, 0.120261, -0.213553, {0, 0, 1.33723}, {0, -0.926789, -0.572488}},
      {0, 3.92857, 0.222826, 0.676211, -0.0337175, {-0.329521, 0, 0.868839}, {0, -0.13933, -0.513288}},
      {0, 2.99794, 0.762432, 0.666667, -0, {-1.14365, 0, 0.487216}, {0, 0, -0.578476}},
      {0.000291577, 0.510151, 0.0399395, 0.0445581, -0, {-0.491556, 0, 0.784876}, {0, 0, -0.233218}},
      {0.115944, 0.583252, 0.359298, 0.113608, -0, {-0.569557, 0, 0.873465}, {0, 0, 0}},
      {0.0326572, 0.323643, 0.164359, 0.0851859, -0, {-0.61121, 0, 0.804441}, {0, 0, -0.953363}},
      {0.00793175, 0.691095, 0.488048, 0.13859, 1.63078, {-0.66499, 0, 0.435096}, {-1.27363, -0.200393, 0}},
      {0, 0.602864, 0.0186916, 0.0543893, -0, {-0.288074, 0, 0.869992}, {0, 0, -0.465798}},
    }},
    .products = {
      {Feature{0}, Feature{1}, 0},
      {Feature{0}, Feature{2}, 0},
      {Feature{0}, Feature{3}, -0.0116184},
      {Feature{0}, Feature{4}, 0},
      {Feature{0}, Feature{5}, 0},
      {Feature{0}, Feature{6}, 0.131324},
      {Feature{0}, Feature{7}, 0},
      {Feature{0}, Feature{8}, 0.448439},
      {Feature{0}, Feature{9}, 0},
      {Feature{0}, Feature{10}, 0.0339644},
      {Feature{0}, Feature{11}, 0},
      {Feature{0}, Feature{12}, 0},
      {Feature{0}, Feature{13}, 0},
      {Feature{0}, Feature{14}, 0},
      {Feature{0}, Feature{15}, 0},
      {Feature{0}, Feature{16}, 0},
      {Feature{0}, Feature{17}, 0},
      {Feature{16}, Feature{1}, 0},
      {Feature{16}, Feature{2}, 0},
      {Feature{16}, Feature{3}, 0},
      {Feature{16}, Feature{4}, 0},
      {Feature{16}, Feature{5}, 0},
      {Feature{16}, Feature{6}, 0.180787},
      {Feature{16}, Feature{7}, 0},
      {Feature{16}, Feature{8}, 0},
      {Feature{16}, Feature{9}, 0},
      {Feature{16}, Feature{10}, 0},
      {Feature{16}, Feature{11}, 0},
      {Feature{16}, Feature{12}, 0},
      {Feature{16}, Feature{13}, 0},
      {Feature{16}, Feature{14}, 0},
      {Feature{16}, Feature{15}, 0},
      {Feature{16}, Feature{17}, 0},
      {Feature{9}, Feature{1}, 0},
      {Feature{9}, Feature{2}, 0},
      {Feature{9}, Feature{3}, 0},
      {Feature{9}, Feature{4}, 0},
      {Feature{9}, Feature{5}, 0},
      {Feature{9}, Feature{6}, 0},
      {Feature{9}, Feature{7}, 0},
      {Feature{9}, Feature{8}, 0.142561},
      {Feature{9}, Feature{10}, -0.247093},
      {Feature{9}, Feature{11}, -0.0729906},
      {Feature{9}, Feature{12}, 0},
      {Feature{9}, Feature{13}, 0},
      {Feature{9}, Feature{14}, 0},
      {Feature{9}, Feature{15}, 0},
      {Feature{9}, Feature{17}, 0},
    },
    .least_probability = 0.902048,
  };
  return model;
}

}  // namespace binpick
// clang-format on
