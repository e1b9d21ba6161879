#pragma once

namespace binpick {

inline constexpr int kExitOk = 0;
inline constexpr int kExitGateFailed = 1;  ///< also: results that should be equal differ
inline constexpr int kExitInput = 2;       ///< usage, configuration, input
inline constexpr int kExitIo = 3;
inline constexpr int kExitInternal = 4;
inline constexpr int kExitSignal = 128;  ///< plus the signal's number

}  // namespace binpick
