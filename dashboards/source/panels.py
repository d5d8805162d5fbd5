"""Kinds of panels, with settings that all dashboards share. Each is a builder of Grafana's SDK: callers add to it."""

import typing

from grafana_foundation_sdk.builders import (
    barchart as barcharts,
    bargauge as bargauges,
    common,
    dashboard,
    heatmap as heatmaps,
    prometheus,
    stat as stats,
    statetimeline as timelines,
    table as tables,
    timeseries as lines,
    xychart as xycharts,
)
from grafana_foundation_sdk.cog.builder import Builder
from grafana_foundation_sdk.models import heatmap as heat, xychart as xy
from grafana_foundation_sdk.models.common import (
    AxisPlacement,
    BarGaugeDisplayMode,
    BarGaugeNamePlacement,
    BarGaugeSizing,
    BarGaugeValueMode,
    BigValueColorMode,
    BigValueGraphMode,
    BigValueJustifyMode,
    BigValueTextMode,
    GraphDrawStyle,
    HeatmapCellLayout,
    LegendDisplayMode,
    LegendPlacement,
    SortOrder,
    StackingMode,
    TableCellHeight,
    TimelineValueAlignment,
    TooltipDisplayMode,
    VisibilityMode,
    VizOrientation,
)
from grafana_foundation_sdk.models.dashboard import (
    FieldColorModeId,
    Threshold,
    ThresholdsMode,
    ValueMap,
    ValueMappingResult,
)
from grafana_foundation_sdk.models.prometheus import PromQueryFormat

Panel = typing.TypeVar(
    "Panel",
    barcharts.Panel,
    bargauges.Panel,
    heatmaps.Panel,
    lines.Panel,
    stats.Panel,
    tables.Panel,
    timelines.Panel,
    xycharts.Panel,
)


def common_of(panel: Panel, title, description, unit, targets, size, steps=None) -> Panel:
    """What all panels have; `steps` are (value, colour) from low to high, the first value None."""
    mode = FieldColorModeId.THRESHOLDS if steps else FieldColorModeId.PALETTE_CLASSIC
    panel.title(title).description(description).unit(unit).color_scheme(dashboard.FieldColor().mode(mode))
    if steps:
        listed = [Threshold(value, color) for value, color in steps]
        panel.thresholds(dashboard.ThresholdsConfig().mode(ThresholdsMode.ABSOLUTE).steps(listed))
    panel.datasource(targets[0].build().datasource)
    for letter, target in zip("ABCDEFGH", targets):
        panel.with_target(target.ref_id(letter))
    width, height = size
    return panel.span(width).height(height)


def legend() -> common.VizLegendOptions:
    listed = common.VizLegendOptions().display_mode(LegendDisplayMode.LIST)
    return listed.placement(LegendPlacement.BOTTOM).show_legend(True).calcs([])


def tooltip() -> common.VizTooltipOptions:
    return common.VizTooltipOptions().mode(TooltipDisplayMode.MULTI).sort(SortOrder.DESCENDING)


def tooltip_of_one() -> common.VizTooltipOptions:
    return common.VizTooltipOptions().mode(TooltipDisplayMode.SINGLE).sort(SortOrder.NONE)


def newest(fields="") -> common.ReduceDataOptions:
    """The newest value; with `/.*/` also of texts."""
    return common.ReduceDataOptions().calcs(["lastNotNull"]).fields(fields).values(False)


def timeseries(title, description, unit, targets, size=(8, 8), stacked=False, bars=False, from_0=True) -> lines.Panel:
    """Lines over time."""
    panel = common_of(lines.Panel(), title, description, unit, targets, size)
    stacking = common.StackingConfig().mode(StackingMode.NORMAL if stacked else StackingMode.NONE).group("A")
    panel.draw_style(GraphDrawStyle.BARS if bars else GraphDrawStyle.LINE).stacking(stacking)
    panel.line_width(1).fill_opacity(60 if bars else 15 if stacked else 0).span_nulls(False)
    panel.show_points(VisibilityMode.NEVER if stacked or bars else VisibilityMode.AUTO).point_size(4)
    if from_0:
        panel.axis_soft_min(0)
    return panel.legend(legend()).tooltip(tooltip())


def stat(title, description, unit, target, steps=None, size=(4, 4), trend=True) -> stats.Panel:
    """One number; with a trend if the query gives values over time."""
    panel = common_of(stats.Panel(), title, description, unit, [target], size, steps or [(None, "text")])
    is_trend = trend and isinstance(target, prometheus.Dataquery) and not target.build().instant
    panel.graph_mode(BigValueGraphMode.AREA if is_trend else BigValueGraphMode.NONE).color_mode(BigValueColorMode.VALUE)
    panel.text_mode(BigValueTextMode.AUTO).justify_mode(BigValueJustifyMode.AUTO).wide_layout(True)
    return panel.reduce_options(newest()).orientation(VizOrientation.AUTO)


def table(title, description, target, columns, size=(24, 9), unit="none") -> tables.Panel:
    """A table; `columns` are overrides for some columns."""
    panel = common_of(tables.Panel(), title, description, unit, [target], size)
    return panel.show_header(True).cell_height(TableCellHeight.SM).filterable(True).overrides(columns)


def xychart(title, description, unit, targets, pairs, size=(12, 9)) -> xycharts.Panel:
    """One number against another: `pairs` are (number of the query, x, y, name)."""
    panel = common_of(xycharts.Panel(), title, description, unit, targets, size)
    by = lambda kind, value: xycharts.MatcherConfig().id(kind).options(value)
    listed: list[Builder[xy.XYSeriesConfig]] = [
        xycharts.XYSeriesConfig()
        .frame(xycharts.XychartXYSeriesConfigFrame().matcher(by("byIndex", index)))
        .x(xycharts.XychartXYSeriesConfigX().matcher(by("byName", x)))
        .y(xycharts.XychartXYSeriesConfigY().matcher(by("byName", y)))
        .name(xycharts.XychartXYSeriesConfigName().fixed(name))
        for index, x, y, name in pairs
    ]
    panel.mapping(xy.SeriesMapping.MANUAL).series(listed).show(xy.XYShowMode.POINTS).line_width(1)
    panel.point_size(xycharts.XychartFieldConfigPointSize().fixed(6)).point_shape(xy.PointShape.CIRCLE)
    return panel.point_stroke_width(1).legend(legend()).tooltip(tooltip_of_one())


def barchart(title, description, unit, target, x_field, size=(12, 9)) -> barcharts.Panel:
    """Bars by category."""
    panel = common_of(barcharts.Panel(), title, description, unit, [target], size)
    panel.x_field(x_field).orientation(VizOrientation.VERTICAL).show_value(VisibilityMode.NEVER)
    panel.stacking(StackingMode.NONE).group_width(0.8).bar_width(0.9).x_tick_label_rotation(0)
    panel.line_width(1).fill_opacity(70).axis_soft_min(0)
    return panel.legend(legend()).tooltip(tooltip())


def bargauge(title, description, unit, target, size=(12, 8)) -> bargauges.Panel:
    """A bar for the present value of each series."""
    panel = common_of(bargauges.Panel(), title, description, unit, [target], size)
    panel.display_mode(BarGaugeDisplayMode.BASIC).orientation(VizOrientation.HORIZONTAL).show_unfilled(True)
    panel.value_mode(BarGaugeValueMode.COLOR).name_placement(BarGaugeNamePlacement.LEFT).sizing(BarGaugeSizing.AUTO)
    return panel.legend(legend().show_legend(False)).reduce_options(newest())


def heatmap(title, description, unit, target, size=(12, 8)) -> heatmaps.Panel:
    """A histogram of Prometheus over time."""
    panel = common_of(heatmaps.Panel(), title, description, unit, [target.format(PromQueryFormat.HEATMAP)], size)
    color = heatmaps.HeatmapColorOptions().mode(heat.HeatmapColorMode.SCHEME).scheme("Oranges")
    panel.calculate(False).cell_gap(1).color(color.steps(64).exponent(0.5).reverse(False))
    panel.rows_frame(heatmaps.RowsHeatmapOptions().layout(HeatmapCellLayout.AUTO))
    panel.cell_values(heatmaps.CellValues().unit("short"))
    panel.y_axis(heatmaps.YAxisConfig().unit(unit).axis_placement(AxisPlacement.LEFT).reverse(False))
    panel.filter_values(heatmaps.FilterValueRange().le(1e-9)).show_value(VisibilityMode.NEVER)
    return panel.show_legend().mode(TooltipDisplayMode.SINGLE).hide_y_histogram().show_color_scale(False)


def timeline(title, description, targets, words, size=(24, 8)) -> timelines.Panel:
    """States over time; `words` gives each its colour."""
    panel = common_of(timelines.Panel(), title, description, "string", targets, size)
    listed = {word: ValueMappingResult(word, color, index=at) for at, (word, color) in enumerate(words.items())}
    panel.mappings([ValueMap(listed)]).merge_values(True).show_value(VisibilityMode.AUTO)
    panel.align_value(TimelineValueAlignment.LEFT).row_height(0.85).fill_opacity(70).line_width(0)
    return panel.legend(legend()).tooltip(tooltip_of_one())
