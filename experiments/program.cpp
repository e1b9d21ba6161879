#include "experiments/program.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string_view>

#include "experiments/exit_codes.h"
#include "experiments/merge_command.h"
#include "experiments/report_command.h"
#include "experiments/reproduce_command.h"
#include "experiments/run_command.h"
#include "experiments/status_command.h"
#include "experiments/view_command.h"
#include "experiments/worker_loop.h"
#include "models/errors.h"

namespace binpick {
namespace {

int parse_and_run(int argc, char** argv, const TrialKindRegistry& registry,
                  const std::vector<AddCommand>& more) {
  int exit_code = kExitOk;
  CLI::App app("A physics-simulated bin-picking testbed", "binpick");
  app.require_subcommand(1);
  app.set_version_flag("--version", BINPICK_VERSION);
  add_run_command(app, registry, exit_code);
  add_report_command(app, registry, exit_code);
  add_merge_command(app, registry, exit_code);
  add_status_command(app, registry, exit_code);
  add_reproduce_command(app, registry, exit_code);
  add_view_command(app, registry, exit_code);
  for (const AddCommand& add : more) add(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // Help and version arrive here too, as success.
    return app.exit(error) == 0 ? kExitOk : kExitInput;
  }
  return exit_code;
}

int report_failure(const std::exception& error, int exit_code) {
  fmt::print(stderr, "{}\n", error.what());
  return exit_code;
}

}  // namespace

int program_main(int argc, char** argv, const TrialKindRegistry& registry,
                 const std::vector<AddCommand>& more) {
  // A closed pipe and a file-size limit are errors to report, not reasons to die.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  if (argc == 2 && std::string_view(argv[1]) == "worker") return run_worker_loop(registry);
  int exit_code = kExitInternal;
  try {
    exit_code = parse_and_run(argc, argv, registry, more);
  } catch (const InputError& error) {
    exit_code = report_failure(error, kExitInput);
  } catch (const IoError& error) {
    exit_code = report_failure(error, kExitIo);
  } catch (const std::exception& error) {
    exit_code = report_failure(error, kExitInternal);
  }
  if (std::fflush(stdout) != 0 && exit_code == kExitOk) {
    std::fputs("standard output cannot be written\n", stderr);
    exit_code = kExitIo;
  }
  return exit_code;
}

}  // namespace binpick
