#include "experiments/view_command.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "experiments/exit_codes.h"
#include "experiments/present_results.h"
#include "experiments/report_page.h"
#include "experiments/report_replays.h"
#include "experiments/report_traces.h"
#include "experiments/trial_choice.h"
#include "experiments/write_file.h"
#include "models/errors.h"

namespace binpick {
namespace {

struct ViewArguments {
  std::string folder;
  TrialChoice choice;
};

bool is_set(const char* variable) {
  const char* value = std::getenv(variable);
  return value != nullptr && *value != '\0';
}

/// Hands the file to the desktop. @return whether somebody took it.
bool open_on_desktop(const std::filesystem::path& page) {
  std::string program = "xdg-open";
  std::string file = page.string();
  char* const argv[] = {program.data(), file.data(), nullptr};
  pid_t process = 0;
  if (::posix_spawnp(&process, program.c_str(), nullptr, nullptr, argv, environ) != 0) return false;
  int status = 0;
  return ::waitpid(process, &status, 0) == process && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::filesystem::path write_view(const ViewArguments& arguments,
                                 const TrialKindRegistry& registry) {
  const ResultFolder folder(std::filesystem::absolute(arguments.folder).lexically_normal());
  const RunResults results = folder.read();
  const Experiment experiment = experiment_of(results.manifest, registry);
  const TrialKey key{experiment.cell(arguments.choice.cell).key, arguments.choice.trial};
  (void)results.trial(key);
  make_traces(folder, experiment, results, {key});
  std::vector<TrialTrace> traces = find_traces(folder.path(), results);
  std::erase_if(traces, [&](const TrialTrace& trace) { return !(trace.key == key); });
  if (traces.empty()) {
    throw InputError(fmt::format("{}: trial {} of cell {} cannot be repeated here, see above",
                                 arguments.folder, key.trial, key.cell));
  }
  const TraceSection shown =
      trace_section(folder.path(), results, traces, replay_script(), kMostTraceBytes);
  std::filesystem::path page =
      folder.path() / ("view_" + trace_folder(key).filename().string() + ".html");
  write_file(page, report_page(experiment.config().heading(), shown.html));
  return page;
}

}  // namespace

void add_view_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code) {
  auto arguments = std::make_shared<ViewArguments>();
  CLI::App* command =
      app.add_subcommand("view", "Look at one trial: a page with its pictures and its 3-D replay");
  command->add_option("DIR", arguments->folder, "results folder")->required();
  add_trial_choice(*command, arguments->choice);
  command->callback([arguments, &registry, &exit_code] {
    const std::filesystem::path page = write_view(*arguments, registry);
    fmt::print("{}\n", page.string());
    if (!is_set("DISPLAY") && !is_set("WAYLAND_DISPLAY")) {
      fmt::print(stderr, "no display here: open this page in a browser, on any machine\n");
    } else if (!open_on_desktop(page)) {
      fmt::print(stderr, "xdg-open does not open it: open this page in a browser\n");
    }
    exit_code = kExitOk;
  });
}

}  // namespace binpick
