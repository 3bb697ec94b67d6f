// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/field.h"

#include <utility>

namespace cornice {

Field::Field(Lattice lattice, std::vector<FieldLevel> levels)
    : lattice_(lattice), levels_(std::move(levels)) {}

}  // namespace cornice
