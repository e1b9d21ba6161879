#pragma once

#include <fstream>
#include <functional>
#include <memory>

#include "control/manipulation_automaton.h"
#include "experiments/trial_kind.h"
#include "sim/world.h"

namespace binpick {

/// Writes what a trial's context asks for: a film with the depth camera's view inset, and a folder
/// with a trace of the arm (trace.csv, one row per 10 ms), the automaton's transitions
/// (events.csv), pictures of the start, of every grasp and of the end (PNG, numbered), and the
/// replay (replay.json, see TrialReplay). Only looks, so that recording changes nothing.
class TrialRecorder {
 public:
  /// @throws IoError when the trace or the film cannot be written.
  TrialRecorder(const TrialContext& context, World& world);
  /// Takes the last picture and writes the replay; says on stderr what cannot be written.
  ~TrialRecorder();
  TrialRecorder(const TrialRecorder&) = delete;
  TrialRecorder& operator=(const TrialRecorder&) = delete;

  /// To be called after each step of the world; empty when nothing is recorded.
  [[nodiscard]] std::function<void(World&)> callback();
  void note(const AutomatonEvent& event);

 private:
  struct Film;
  struct Album;

  void record(World& world);
  void write_trace_row(World& world);

  World& world_;
  std::ofstream trace_;
  std::ofstream events_;
  std::unique_ptr<Album> album_;
  std::unique_ptr<Film> film_;
  long steps_ = 0;
};

}  // namespace binpick
