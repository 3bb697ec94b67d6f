# SPDX-License-Identifier: GPL-3.0-or-later
# The front door. CMake does the work; see CMakePresets.json for the other builds.
PREFIX ?= /usr/local
JOBS ?= $(shell nproc)
SOURCES = find bench core hlod pipeline stages terrain-viewer tests -name '*.h' -o -name '*.cpp'

.PHONY: help setup build programs demo test bench install format lint clean
.DEFAULT_GOAL := help

help: ## list these targets
	@sed -n 's/^\([a-z]*\):.*## /make \1\t/p' Makefile | expand -t 18

setup: ## install the packages that are missing
	@scripts/setup

build: setup ## compile everything into build/
	@cmake --preset release
	@cmake --build --preset release -j $(JOBS)

programs: setup ## compile the programs alone, without tests and benchmarks
	@cmake --preset release
	@cmake --build --preset release -j $(JOBS) --target cornice-programs

demo: programs ## simulate a survey, process it, and show it in demo-output/report.html
	@scripts/demo build/bin

test: build ## run every test
	@ctest --preset release -j 2

bench: build ## run every benchmark; results in build/bench/*.json
	@scripts/bench build/bin build/bench

install: programs ## install the programs; PREFIX=/usr/local unless given
	@cmake --install build --prefix "$(PREFIX)"

format: ## format the sources with clang-format
	@scripts/setup lint
	@$(SOURCES) | xargs clang-format -i

lint: ## check the format, then run clang-tidy; any finding fails
	@scripts/setup build lint
	@$(SOURCES) | xargs clang-format --dry-run -Werror
	@cmake --preset release
	@$(SOURCES) | grep '\.cpp$$' | xargs -P $(JOBS) -n 4 clang-tidy -p build --quiet \
	    --extra-arg=-Wno-unknown-warning-option

clean: ## remove what was built and shown
	@rm -rf build build-* demo-output
