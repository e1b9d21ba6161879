#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "experiments/report_traces.h"

namespace binpick {

/// The part of the report that shows single trials: pictures, links to the trace's files, the
/// command that repeats the trial, and one player for the 3-D replays of all of them.
struct TraceSection {
  std::string html;
  std::map<TrialKey, std::string> anchors;  ///< of the trials that it shows
};

/// Of pictures and replays in a page that is to be sent by mail and opened on a phone.
inline constexpr std::size_t kMostTraceBytes = 18'000'000;

/// The bundled script of the 3-D view, empty when this build has none.
[[nodiscard]] std::string replay_script();

/// Reads the traces' files below `results_folder` into the page until `most_bytes` are used; says
/// what had to stay outside. Without traces, says how to get them.
/// @param script see replay_script; without it, pictures are shown, and what is missing is said.
/// @throws IoError when a file cannot be read, InputError when a replay is none.
[[nodiscard]] TraceSection trace_section(const std::filesystem::path& results_folder,
                                         const RunResults& results,
                                         const std::vector<TrialTrace>& traces,
                                         const std::string& script, std::size_t most_bytes);

}  // namespace binpick
