#pragma once

namespace binpick {

struct AcceptanceModel;

/// Two settings of one engine.
enum class RecognizerSetting {
  kPaper,    ///< Algorithm 1 of IJRR 2012 as printed
  kDefault,  ///< Algorithm 1 plus what makes it fast and precise; see docs of Recognizer
};

/// What a user may want to say. Nothing here has to be tuned to objects, sensor or unit: pair
/// width, leaf size, tolerances and normal radius follow from the models, the scene's resolution
/// and its measured noise.
struct RecognizerOptions {
  RecognizerSetting setting = RecognizerSetting::kDefault;

  /// P_S, the wanted probability of drawing at least one good pair on an object that shows no less
  /// than `visibility` of its surface; in (0, 1). More costs time as -ln(1 - P_S).
  /// IJRR 2012, eq. (11).
  double success_probability = 0.99;

  /// V, the least visible share of a model's whole surface, in (0, 1). Lower finds more hidden
  /// objects and more false ones. IJRR 2012, section 6.1.1: false positives grow below 0.15.
  double visibility = 0.15;

  /// P, the largest share of a model's surface that may hide measured points, in (0, 1).
  /// IJRR 2012, eq. (7).
  double penalty = 0.05;

  /// C, the assumed share of the shell round a point of an object that belongs to the same object,
  /// in (0, 1]. IJRR 2012, section 4.3.
  double same_object_share = 0.25;

  /// Whether to refine the accepted poses (point-to-plane, robust).
  bool refine = true;

  /// Decides about hypotheses (default setting); null means the calibrated one. Not owned.
  const AcceptanceModel* acceptance = nullptr;

  /// Whether the result lists every hypothesis that was verified, with what spoke for and against
  /// it: for calibration and diagnosis.
  bool keep_considered = false;

  /// Threads, at least 1. The result is the same for any number.
  int jobs = 1;

  /// @throws InputError listing every value out of range.
  void validate() const;
};

}  // namespace binpick
