#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/experiment.h"
#include "experiments/result_folder.h"

namespace binpick {

/// What `binpick reproduce --trace` left of a trial.
struct TrialTrace {
  TrialKey key;
  std::filesystem::path folder;    ///< relative to the results folder
  std::vector<std::string> files;  ///< names, sorted
};

/// Where the trace of a trial lies, relative to its results folder.
[[nodiscard]] std::filesystem::path trace_folder(const TrialKey& key);

/// Writes into `folder`, a finished trace, of which trial of which run it is.
/// @throws IoError
void sign_trace(const std::filesystem::path& folder, const RunManifest& manifest,
                const TrialRecord& record);

/// The traces in a results folder that are of these results: a trace of another run, or one that
/// ended otherwise than the stored trial, does not count.
[[nodiscard]] std::vector<TrialTrace> find_traces(const std::filesystem::path& results_folder,
                                                  const RunResults& results);

/// The trials that are worth a look, at most `most`: failed ones first, then others, taking the
/// cells in turn. Trials that crashed are left out.
[[nodiscard]] std::vector<TrialKey> trials_to_trace(const Experiment& experiment,
                                                    const TrialTable& trials, std::size_t most);

/// Runs the trials again that have no trace yet, each in a process of its own (`binpick
/// reproduce`), one per core at a time. Says on stderr which of them could not be traced.
void make_traces(const ResultFolder& folder, const Experiment& experiment,
                 const RunResults& results, const std::vector<TrialKey>& trials);

}  // namespace binpick
