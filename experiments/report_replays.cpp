#include "experiments/report_replays.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "experiments/base64.h"
#include "experiments/html.h"
#include "experiments/reproduce_line.h"
#include "models/errors.h"

namespace binpick {
namespace {

using nlohmann::json;

constexpr const char* kReplayFile = "replay.json";

std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw IoError(fmt::format("{}: cannot be read", path.string()));
  return {std::istreambuf_iterator<char>(file), {}};
}

/// JSON that cannot end the element that it stands in.
std::string embedded(const json& data) {
  std::string text;
  for (const char c : data.dump()) c == '<' ? text += "\\u003c" : text += c;
  return text;
}

std::string data_element(const std::string& id, const std::string& text) {
  return fmt::format("<script type=\"application/json\" id=\"{}\">{}</script>\n", id, text);
}

/// "02_rusk_held_12.30s.png" -> "rusk held 12.30s"
std::string caption_of(const std::string& file) {
  std::string caption = std::filesystem::path(file).stem().string();
  std::replace(caption.begin(), caption.end(), '_', ' ');
  const std::size_t space = caption.find(' ');
  const bool numbered =
      space != std::string::npos && space > 0 && caption.find_first_not_of("0123456789") == space;
  return numbered ? caption.substr(space + 1) : caption;
}

class SectionWriter {
 public:
  SectionWriter(const std::filesystem::path& results_folder, const RunResults& results,
                bool with_script, std::size_t most_bytes)
      : folder_(results_folder), results_(results), with_script_(with_script), left_(most_bytes) {}

  void add(const TrialTrace& trace) {
    const std::string anchor = fmt::format("trial-{}", anchors_.size());
    anchors_[trace.key] = anchor;
    const TrialRecord& record = results_.trials.at(trace.key).record;
    const std::string label =
        fmt::format("{}, trial {}: {}", trace.key.cell, trace.key.trial, to_text(record.outcome));
    cards_ += fmt::format("<article id=\"{}\">\n<h3>{}</h3>\n", anchor, html_escape(label));
    if (!record.note.empty()) cards_ += "<p>" + html_escape(record.note) + "</p>\n";
    const std::optional<std::string> replay = add_replay(trace, label);
    cards_ += "<p>" + replay.value_or("") + links(trace) + "</p>\n";
    cards_ +=
        "<p><code>" + html_escape(reproduce_line(folder_.string(), trace.key)) + "</code></p>\n";
    add_pictures(trace);
    cards_ += "</article>\n";
  }

  [[nodiscard]] std::string cards() const { return cards_; }
  [[nodiscard]] std::string data() const {
    return index_.empty() ? "" : data_ + data_element("replay-index", embedded(index_));
  }
  [[nodiscard]] bool has_replays() const { return !index_.empty(); }
  [[nodiscard]] std::size_t left_outside() const { return left_outside_; }
  [[nodiscard]] std::map<TrialKey, std::string> anchors() const { return anchors_; }

 private:
  /// Whether a part of this size still goes into the page.
  bool claim(std::size_t bytes) {
    if (bytes > left_) {
      ++left_outside_;
      return false;
    }
    left_ -= bytes;
    return true;
  }

  std::optional<std::string> add_replay(const TrialTrace& trace, const std::string& label) {
    const auto& files = trace.files;
    if (!with_script_ || std::find(files.begin(), files.end(), kReplayFile) == files.end()) {
      return std::nullopt;
    }
    const std::filesystem::path file = folder_ / trace.folder / kReplayFile;
    json replay = json::parse(read_file(file), nullptr, false);
    if (!replay.is_object() || !replay.contains("scene")) {
      throw InputError(file.string() + ": is no replay; remove it and make the report again");
    }
    const std::string scene = embedded(std::exchange(replay["scene"], nullptr));
    const std::string motion = embedded(replay);
    const bool known = scenes_.contains(scene);
    if (!claim(motion.size() + (known ? 0 : scene.size()))) return std::nullopt;
    const auto [found, fresh] = scenes_.emplace(scene, fmt::format("scene-{}", scenes_.size()));
    if (fresh) data_ += data_element(found->second, scene);
    const std::string number = fmt::format("{}", index_.size());
    data_ += data_element("replay-data-" + number, motion);
    index_.push_back(
        {{"label", label}, {"scene", found->second}, {"data", "replay-data-" + number}});
    return "<a href=\"#replay-" + number + "\">3-D replay</a> ";
  }

  [[nodiscard]] static std::string links(const TrialTrace& trace) {
    std::string html;
    for (const std::string& file : trace.files) {
      if (!file.ends_with(".csv")) continue;
      html += fmt::format("<a href=\"{}\">{}</a> ",
                          html_escape((trace.folder / file).generic_string()), html_escape(file));
    }
    return html;
  }

  void add_pictures(const TrialTrace& trace) {
    cards_ += "<div class=\"pictures\">\n";
    for (const std::string& file : trace.files) {
      if (!file.ends_with(".png")) continue;
      const std::string bytes = read_file(folder_ / trace.folder / file);
      const std::string text = base64(std::as_bytes(std::span(bytes)));
      if (!claim(text.size())) continue;
      const std::string caption = html_escape(caption_of(file));
      cards_ += fmt::format(
          "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"/>"
          "<figcaption>{0}</figcaption></figure>\n",
          caption, text);
    }
    cards_ += "</div>\n";
  }

  const std::filesystem::path& folder_;
  const RunResults& results_;
  bool with_script_;
  std::size_t left_;
  std::size_t left_outside_ = 0;
  std::string cards_;
  std::string data_;
  std::map<std::string, std::string> scenes_;  // JSON -> id of its element
  json index_ = json::array();
  std::map<TrialKey, std::string> anchors_;
};

}  // namespace

std::string replay_script() {
  std::ifstream file(BINPICK_REPLAY_PAGE, std::ios::binary);
  return file ? std::string(std::istreambuf_iterator<char>(file), {}) : std::string();
}

TraceSection trace_section(const std::filesystem::path& results_folder, const RunResults& results,
                           const std::vector<TrialTrace>& traces, const std::string& script,
                           std::size_t most_bytes) {
  std::string html = "<h2 id=\"trials\">Single trials</h2>\n";
  if (traces.empty()) {
    html += fmt::format(
        "<p>Pictures, traces and 3-D replays of single trials, failed ones first, come with "
        "<code>binpick report {}</code></p>\n",
        html_escape(shell_word(results_folder.string())));
    return {html, {}};
  }
  SectionWriter writer(results_folder, results, !script.empty(), most_bytes);
  for (const bool failed : {true, false}) {
    for (const TrialTrace& trace : traces) {
      const TrialOutcome outcome = results.trials.at(trace.key).record.outcome;
      if ((outcome != TrialOutcome::kSuccess) == failed) writer.add(trace);
    }
  }
  if (script.empty()) {
    html +=
        "<p class=\"bad\">The 3-D view of the replays is missing: binpick was built without npm or "
        "without a network. Install npm, build again and make the report again.</p>\n";
  }
  if (writer.left_outside() > 0) {
    html += fmt::format(
        "<p>{} pictures and replays stayed outside, lest this page becomes too large; they lie in "
        "the folder traces.</p>\n",
        writer.left_outside());
  }
  if (writer.has_replays()) {
    html +=
        "<h3>Replays in 3-D</h3>\n<div id=\"replay\"><noscript>The 3-D view needs "
        "JavaScript.</noscript></div>\n" +
        writer.data() + "<script>" + script +
        "</script>\n<p class=\"lead\">The 3-D view is made with three.js, MIT licence; its text "
        "stands at the head of the script in this page.</p>\n";
  }
  return {html + writer.cards(), writer.anchors()};
}

}  // namespace binpick
