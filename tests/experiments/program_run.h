#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "child_process.h"
#include "coin_experiment.h"
#include "experiments/result_folder.h"

namespace binpick {

/// Runs the coin program on a configuration in a folder of its own.
class ProgramRun : public testing::Test {
 protected:
  /// The coin experiment with `parameters` in place of its own.
  void configure(const std::string& parameters, const std::string& time_limit = "20") {
    std::string yaml = kCoinYaml;
    const auto replace = [&](const std::string& what, const std::string& by) {
      yaml.replace(yaml.find(what), what.size(), by);
    };
    replace("rate: 0.6, work_ms: 0", parameters);
    replace("time_limit_s: 20", "time_limit_s: " + time_limit);
    folder_.write("coin.yaml", yaml);
  }

  [[nodiscard]] std::unique_ptr<ChildProcess> start(std::vector<std::string> arguments,
                                                    ChildOptions options = {}) const {
    arguments.insert(arguments.begin(), COIN_PROGRAM);
    options.directory = folder_.path();
    return std::make_unique<ChildProcess>(arguments, options);
  }

  int run(const std::vector<std::string>& arguments, const ChildOptions& options = {}) {
    const auto process = start(arguments, options);
    const int code = process->wait();
    out_ = process->out();
    err_ = process->err();
    return code;
  }

  int run_into(const std::string& out, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"run", "coin.yaml", "--out", out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  /// The canonical bytes of a results folder.
  [[nodiscard]] std::string canonical(const std::string& out) const {
    const std::string json = read_whole_file(folder_ / out / "trials.json");
    EXPECT_THAT(json, testing::HasSubstr("rate=0.9,side=tails"));
    return json + read_whole_file(folder_ / out / "trials.csv");
  }

  [[nodiscard]] nlohmann::json status_of(const std::string& out) {
    EXPECT_EQ(run({"status", out, "--json"}), 0) << err_;
    return nlohmann::json::parse(out_);
  }

  /// Waits until a run has written this many trials; false when that takes too long.
  [[nodiscard]] bool wait_for_trials(const std::string& out, std::int64_t count) {
    const ResultFolder folder(folder_ / out);
    for (int i = 0; i < 2000; ++i) {
      if (!folder.stores().empty() && std::ssize(folder.read().trials) >= count) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  /// Waits until the process has a worker; false when it ended before.
  static bool wait_for_worker(const ChildProcess& process) {
    for (int i = 0; i < 500; ++i) {
      if (!process.children().empty()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }

  TemporaryFolder folder_;
  std::string out_;
  std::string err_;
};

}  // namespace binpick
