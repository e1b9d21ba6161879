#pragma once

#include <string>

#include "experiments/experiment.h"

namespace binpick {

/// The part of the report that plots a contact experiment as IJRR 2012, Figs. 5 and 6 do: contact
/// force, height and velocity over time, desired and measured, with hf1; one panel per reaction and
/// stiffness, slow and fast runs in each. Empty for experiments of other kinds.
/// Runs the first trial of every cell again, which takes about a second: a trial is a pure function
/// of the experiment, and records carry no time series.
/// @throws InputError when the experiment's input files are gone.
[[nodiscard]] std::string contact_section(const Experiment& experiment);

}  // namespace binpick
