#pragma once

#include <string>

#include "recognition/model_library.h"
#include "recognition/recognition_score.h"
#include "recognition/recognizer.h"
#include "recognition/synthetic_scene.h"

namespace binpick::testing {

/// Why a true instance was not found, in one line: where on the way from scene points to detections
/// it got lost. Needs a result with RecognizerOptions::keep_considered.
[[nodiscard]] std::string diagnose_miss(const SyntheticFrame& frame, std::size_t instance,
                                        const RecognitionResult& result,
                                        const ModelLibrary& library);

/// What a false detection lies on, and what spoke for it least.
[[nodiscard]] std::string diagnose_false(const SyntheticFrame& frame, std::size_t detection,
                                         const RecognitionResult& result,
                                         const ModelLibrary& library);

}  // namespace binpick::testing
