#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "experiments/experiment.h"

namespace binpick {

/// What a result store says about its origin.
struct RunManifest {
  // What decides the records: results that differ here are never mixed.
  std::string experiment;
  std::string identity;  ///< Experiment::identity_hash
  std::string inputs;    ///< Experiment::inputs_hash
  std::string protocol;  ///< TrialKind::protocol_version
  std::string program;   ///< version of binpick
  std::string build;     ///< hash of the executable
  // What goes with them.
  std::string config;     ///< Experiment::config_hash
  std::string yaml;       ///< the effective configuration
  std::string directory;  ///< where its relative paths start
  // Where the trials ran: every one that took part, joined by '|'.
  std::string cpu;   ///< feature classes of processors; records are equal within one class
  std::string host;  ///< machines, e.g. "node3 (Linux 6.1.0)"

  [[nodiscard]] static RunManifest of(const Experiment& experiment);
  [[nodiscard]] static RunManifest from_entries(const std::map<std::string, std::string>& entries);
  [[nodiscard]] std::map<std::string, std::string> entries() const;
  /// Adds the processors and hosts of `other`, which holds results of the same run.
  void add_origins(const RunManifest& other);
  /// Says in one line why results of `other` cannot join these; empty when they can.
  [[nodiscard]] std::string conflict_with(const RunManifest& other) const;
};

/// The release, e.g. "0.1.0".
[[nodiscard]] std::string program_version();
/// Hash of the running executable.
[[nodiscard]] std::string program_build();
/// The instruction-set extensions that change floating-point results, e.g. "x86-64 avx2 fma".
[[nodiscard]] std::string cpu_class();
/// This machine: name, operating system and its release.
[[nodiscard]] std::string host_name();

}  // namespace binpick
