// Written by recognition_calibration --scenes 240 --passes 2
// (tests/recognition/acceptance_calibration_main.cpp); not edited by hand.

#include "recognition/acceptance_model.h"

// clang-format off
namespace binpick {

const AcceptanceModel& calibrated_acceptance() {
  static const AcceptanceModel model = {
    .bias = 4.95366,
    // low, high, centre, scale, slope, knots, bends
    .terms = {{
      {4.43082, 9.44328, 6.88449, 0.862196, 1.40018, {-0.639306, 0, 0.655316}, {-1.3853, 0, 0}},
      {-2.59607, 0.19004, -0.638638, 0.576655, 1.1083, {-0.752993, 0, 0.665549}, {-0.970083, 0.0962852, 1.2821}},
      {0.0863808, 0.996861, 0.546729, 0.315037, 0, {-0.603761, 0, 0.96565}, {0, 0, 0.530611}},
      {0, 0.440147, 0.156038, 0.103197, -0, {-0.695974, 0, 0.666128}, {0, 0, -0.54992}},
      {0, 0.579517, 0.120704, 0.149097, -0.568036, {-0.509471, 0, 0.972027}, {-0.239093, 0.239093, -0.386611}},
      {0, 0.368171, 0.107295, 0.0853058, -0, {-0.680746, 0, 0.723696}, {0, 0, -0.063614}},
      {0, 0.696607, 0.203334, 0.237583, -2.26292, {-0.493046, 0, 1.14609}, {-0.0461805, -1.11135, 1.15753}},
      {0, 0.58548, 0, 0.015257, -0, {0, 0, 0}, {0, 0, -0.0449413}},
      {0, 0.654654, 0, 0.153897, -2.58352, {0, 0, 1.21234}, {0, 0, 0}},
      {0, 0.875, 0.123711, 0.23301, 2.1075, {-0.470482, 0, 1.0529}, {1.04953, -1.3822, 0.174006}},
      {0, 0.544529, 0, 0.119098, -0.23225, {0, 0, 1.2956}, {0, -0.585769, -0.445159}},
      {0, 4.00762, 0.24874, 0.684332, -0.121528, {-0.363479, 0, 0.889046}, {4.092e-06, 0, -0.564059}},
      {0, 2.94392, 0.797426, 0.703734, -0.0141573, {-1.13314, 0, 0.490023}, {1.20796e-05, -0.499802, -0.258636}},
      {0.000306203, 0.510903, 0.0387814, 0.0463789, -0, {-0.455173, 0, 0.778351}, {0, 0, -0.121517}},
      {0.123897, 0.576372, 0.349665, 0.110927, -0, {-0.534653, 0, 0.891567}, {0, 0, 0}},
      {0.0330631, 0.321485, 0.153845, 0.0837666, -0, {-0.574218, 0, 0.801673}, {0, 0, -0.422134}},
      {0.00768171, 0.684721, 0.492234, 0.137747, 1.29525, {-0.665873, 0, 0.449561}, {-0.99506, 0, 0}},
      {0, 0.564841, 0.0196737, 0.0519952, -0, {-0.316957, 0, 0.852249}, {0, 0, -0.493222}},
    }},
    .products = {
      {Feature{0}, Feature{1}, 0},
      {Feature{0}, Feature{2}, 0},
      {Feature{0}, Feature{3}, 0},
      {Feature{0}, Feature{4}, 0},
      {Feature{0}, Feature{5}, 0},
      {Feature{0}, Feature{6}, 0},
      {Feature{0}, Feature{7}, 0},
      {Feature{0}, Feature{8}, 0.870531},
      {Feature{0}, Feature{9}, 0},
      {Feature{0}, Feature{10}, 0.0434352},
      {Feature{0}, Feature{11}, 0.0409482},
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
      {Feature{16}, Feature{6}, 0.350755},
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
      {Feature{9}, Feature{1}, 0.00464667},
      {Feature{9}, Feature{2}, 0},
      {Feature{9}, Feature{3}, 0},
      {Feature{9}, Feature{4}, 0.176175},
      {Feature{9}, Feature{5}, 0},
      {Feature{9}, Feature{6}, 0.54982},
      {Feature{9}, Feature{7}, 0},
      {Feature{9}, Feature{8}, 0},
      {Feature{9}, Feature{10}, -0.194649},
      {Feature{9}, Feature{11}, 0},
      {Feature{9}, Feature{12}, -0.0266424},
      {Feature{9}, Feature{13}, 0},
      {Feature{9}, Feature{14}, 0},
      {Feature{9}, Feature{15}, 0},
      {Feature{9}, Feature{17}, 0},
    },
    .least_probability = 0.941029,
  };
  return model;
}

}  // namespace binpick
// clang-format on
