#pragma once

#include <gtest/gtest.h>

#include <string>

namespace binpick {

/// The message that `action` throws as an Error, or a test failure.
template <class Error, class Action>
std::string message_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

}  // namespace binpick
