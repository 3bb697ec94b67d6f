// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/cli/log.h"

#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <mutex>

#include "core/cli/console.h"

namespace cornice {
namespace {

/// Hands whole lines to the console, so that they do not run into the progress bar.
class ConsoleSink : public spdlog::sinks::base_sink<std::mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string text(message.payload.data(), message.payload.size());
    const std::string tool(message.logger_name.data(), message.logger_name.size());
    console_line(tool + ": " + level_text(message.level) + text);
  }
  void flush_() override {}

 private:
  static const char* level_text(spdlog::level::level_enum level) {
    if (level >= spdlog::level::err) return "error: ";
    if (level == spdlog::level::warn) return "warning: ";
    return level == spdlog::level::info ? "" : "debug: ";
  }
};

std::shared_ptr<spdlog::logger>& logger() {
  // Shared because spdlog's own interface hands loggers and sinks out so.
  static auto instance =
      std::make_shared<spdlog::logger>("cornice", std::make_shared<ConsoleSink>());
  return instance;
}

}  // namespace

void set_up_log(const std::string& tool, const std::string& level) {
  logger() = std::make_shared<spdlog::logger>(tool, std::make_shared<ConsoleSink>());
  logger()->set_level(level == "error"     ? spdlog::level::err
                      : level == "warning" ? spdlog::level::warn
                      : level == "debug"   ? spdlog::level::debug
                                           : spdlog::level::info);
}

void log_error(const std::string& line) { logger()->log(spdlog::level::err, line); }
void log_warning(const std::string& line) { logger()->log(spdlog::level::warn, line); }
void log_info(const std::string& line) { logger()->log(spdlog::level::info, line); }
void log_debug(const std::string& line) { logger()->log(spdlog::level::debug, line); }

}  // namespace cornice
