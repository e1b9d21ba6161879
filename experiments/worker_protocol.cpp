#include "experiments/worker_protocol.h"

#include <nlohmann/json.hpp>

#include "models/errors.h"

namespace binpick {
namespace {

using Json = nlohmann::json;

std::string line_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string encode(const WorkerOrder& order) {
  if (order.type == WorkerOrder::Type::kSetup) {
    return line_of({{"setup", order.yaml}, {"directory", order.directory}, {"cell", order.cell}});
  }
  return line_of({{"trial", order.trial}, {"cell", order.cell}, {"folder", order.folder}});
}

std::string encode(const WorkerReply& reply) {
  switch (reply.type) {
    case WorkerReply::Type::kReady:
      return R"({"ready":true})";
    case WorkerReply::Type::kStage:
      return line_of({{"stage", std::string(to_text(reply.stage))}});
    case WorkerReply::Type::kRecord:
      // As text within: the record's own form keeps every bit of its numbers.
      return line_of({{"record", to_json(reply.record)}, {"ends", reply.ends}});
    case WorkerReply::Type::kInputError:
      return line_of({{"input_error", reply.message}});
    case WorkerReply::Type::kFailed:
      return line_of({{"failed", reply.message}});
  }
  return "";
}

std::optional<WorkerOrder> decode_order(std::string_view line) {
  try {
    const Json json = Json::parse(line);
    WorkerOrder order;
    order.cell = json.at("cell").get<std::size_t>();
    if (json.contains("setup")) {
      order.type = WorkerOrder::Type::kSetup;
      order.yaml = json.at("setup").get<std::string>();
      order.directory = json.at("directory").get<std::string>();
    } else {
      order.trial = json.at("trial").get<std::int64_t>();
      order.folder = json.at("folder").get<std::string>();
    }
    return order;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::optional<WorkerReply> decode_reply(std::string_view line) {
  try {
    const Json json = Json::parse(line);
    WorkerReply reply;
    if (json.contains("ready")) return reply;
    if (json.contains("stage")) {
      const auto stage = stage_from_text(json.at("stage").get<std::string>());
      if (!stage) return std::nullopt;
      reply.type = WorkerReply::Type::kStage;
      reply.stage = *stage;
    } else if (json.contains("record")) {
      reply.type = WorkerReply::Type::kRecord;
      reply.record = record_from_json(json.at("record").get<std::string>());
      reply.ends = json.at("ends").get<bool>();
    } else if (json.contains("input_error")) {
      reply.type = WorkerReply::Type::kInputError;
      reply.message = json.at("input_error").get<std::string>();
    } else {
      reply.type = WorkerReply::Type::kFailed;
      reply.message = json.at("failed").get<std::string>();
    }
    return reply;
  } catch (const Json::exception&) {
    return std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace binpick
