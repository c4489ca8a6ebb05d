module bw_accuracy_ladder
  !! The rungs of a study of accuracy, and how one of them is measured.
  use bw_beam_units, only: beam_units, units_of
  use bw_case_result, only: case_diverged, case_not_converged, case_result
  use bw_case_tolerance, only: plan_case
  use bw_converged, only: converged_run, most_extended
  use bw_double_double, only: dd
  use bw_error, only: error_type
  use bw_frequency_equation, only: root_type
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_monitor, only: monitor_type
  use bw_price_list, only: all_extended, by_counts, by_products, by_tolerances, by_transform, priced_stages, rung_diverged, &
    rung_measured, rung_out_of_reach, rung_too_long, rung_type
  use bw_case_modes, only: record_stretch
  use bw_refined_root, only: is_coarse
  use bw_root_list, only: root_values, solve_roots
  use bw_rotation, only: acts_in_plane, dimensionless_speed
  use bw_scene, only: changes_shapes, scene_type
  use bw_scene_variant, only: with_counts, with_tolerance
  use bw_timed_runs, only: timed_run
  implicit none (type, external)
  private
  public :: ladder_of, scene_of_rung, take_errors, take_seconds, leave_out_of_reach

  integer, parameter :: coarsest = 2, finest = 11      !! decades of the tolerances
  integer, parameter, public :: counts(*) = [5, 10, 20, 50, 100, 200, 500, 1000, 2000]
  integer, parameter :: batch = 4096                   !! roots solved at a time

contains

  pure function ladder_of(reachable, has_roots) result(rungs)
    !! All rungs, from coarse to fine: tolerances, the finest of them in reach with all roots in extended precision,
    !! counts.
    real(dp), intent(in) :: reachable          !! the finest tolerance in reach
    logical, intent(in) :: has_roots           !! modes have a closed form, else nothing is there to be extended
    type(rung_type), allocatable :: rungs(:)
    integer, parameter :: asked = finest - coarsest + 1
    integer :: i, last
    last = asked + merge(1, 0, has_roots)
    allocate (rungs(last + size(counts)))
    do i = 1, asked
      rungs(i)%ladder = by_tolerances
      rungs(i)%tolerance = 10.0_dp**(-(coarsest + i - 1))
    end do
    if (has_roots) then
      rungs(last)%ladder = all_extended
      rungs(last)%tolerance = rungs(max(1, count(rungs(:asked)%tolerance >= reachable)))%tolerance
    end if
    do i = 1, size(counts)
      rungs(last + i)%ladder = by_counts
      rungs(last + i)%mode_count = counts(i)
    end do
  end function ladder_of

  pure type(scene_type) function scene_of_rung(scene, rung) result(variant)
    !! The scene with a rung's tolerance or counts.
    type(scene_type), intent(in) :: scene
    type(rung_type), intent(in) :: rung
    if (rung%ladder == by_counts) then
      variant = with_counts(scene, rung%mode_count)
    else
      variant = with_tolerance(scene, rung%tolerance)
      variant%modes%extended = rung%ladder == all_extended
    end if
  end function scene_of_rung

  subroutine leave_out_of_reach(converged, monitor, runs, rungs)
    !! Mark the rungs that are not run: tolerances that the program refuses, and those for which a run takes too long.
    type(converged_run), intent(in) :: converged
    class(monitor_type), intent(inout) :: monitor
    type(timed_run), intent(inout) :: runs(:)
    type(rung_type), intent(inout) :: rungs(:)
    integer :: i
    do i = 1, size(rungs)
      if (is_missing(rungs(i)%tolerance)) cycle
      if (rungs(i)%tolerance < converged%reach) then
        rungs(i)%status = rung_out_of_reach
      else if (rungs(i)%tolerance < converged%tolerance) then
        rungs(i)%status = rung_too_long
      else if (rungs(i)%ladder == all_extended) then
        rungs(i)%status = status_extended(runs(i)%scene, monitor)
      end if
      runs(i)%is_timed = rungs(i)%status == rung_measured
    end do
  end subroutine leave_out_of_reach

  integer function status_extended(scene, monitor) result(status)
    !! The status of a rung with every root in extended precision before it is run.
    type(scene_type), intent(in) :: scene
    class(monitor_type), intent(inout) :: monitor
    type(error_type), allocatable :: error
    integer :: count
    call plan_case(scene, monitor, count, error)
    status = rung_measured
    if (allocated(error)) then
      status = rung_out_of_reach
    else if (count > most_extended) then
      status = rung_too_long
    end if
  end function status_extended

  pure subroutine take_errors(scene, result, converged, rung)
    !! Put into a rung what its run yielded beside the converged run.
    type(scene_type), intent(in) :: scene          !! of the rung
    type(case_result), intent(in) :: result
    type(converged_run), intent(in) :: converged
    type(rung_type), intent(inout) :: rung
    rung%mode_count = result%mode_count
    if (result%status == case_not_converged) rung%status = rung_out_of_reach
    if (result%status == case_not_converged) return
    rung%refined_count = refined_count(scene, result%mode_count)
    rung%method = merge(by_transform, by_products, result%response%transformed > 0)
    if (result%status == case_diverged) rung%status = rung_diverged
    rung%error = true_error(result, converged)
    if (.not. allocated(result%response%displacement_error)) return
    rung%estimate = 0.0_dp
    if (converged%peak > 0.0_dp) rung%estimate = maxval(result%response%displacement_error)/converged%peak
  end subroutine take_errors

  pure real(dp) function true_error(result, converged) result(error)
    !! The largest difference of a run's displacement from the converged run's over the peak, at the samples that are finite
    !! in both; 0 where nothing moves.
    type(case_result), intent(in) :: result
    type(converged_run), intent(in) :: converged
    integer :: finite
    error = 0.0_dp
    finite = min(result%response%finite_samples, converged%result%response%finite_samples)
    if (converged%peak == 0.0_dp .or. finite == 0) return
    associate (rung => result%response%displacement(:finite, :), &
               fine => converged%result%response%displacement(:finite, :))
      error = maxval(abs(rung/converged%peak - fine/converged%peak))
    end associate
  end function true_error

  pure subroutine take_seconds(run, rung)
    !! Put the median and the quartiles of the repeats into a rung.
    type(timed_run), intent(in) :: run
    type(rung_type), intent(inout) :: rung
    integer :: i
    rung%repeats = run%seconds%count
    if (rung%repeats == 0) return
    rung%seconds = run%seconds%median()
    rung%lower = run%seconds%quantile(0.25_dp)
    rung%upper = run%seconds%quantile(0.75_dp)
    rung%stages = [(run%stage(i)%median(), i=1, priced_stages)]
  end subroutine take_seconds

  pure integer function refined_count(scene, count) result(refined)
    !! How many of the first `count` modes of beam and mass have their roots solved in extended precision.
    type(scene_type), intent(in) :: scene  !! without sweeps, with a response
    integer, intent(in) :: count
    type(beam_units) :: units
    type(dd), allocatable :: omega
    integer :: first, k
    refined = 0
    if (changes_shapes(scene)) return        ! modes without a closed form have no roots
    units = units_of(scene%beam)
    if (allocated(scene%rotation)) then
      if (acts_in_plane(scene%rotation)) omega = dimensionless_speed(scene%rotation, units)
    end if
    do first = 1, count, batch
      refined = refined + coarse_roots([(k, k=first, min(first + batch - 1, count))], scene%impact%mass_ratio, omega, &
                                       record_stretch(scene)*(scene%response%duration/units%time%hi))
    end do
  end function refined_count

  pure integer function coarse_roots(number, gamma, omega, longest) result(coarse)
    !! How many of these roots double precision leaves too coarse for a record.
    integer, intent(in) :: number(:)       !! of the modes
    real(dp), intent(in) :: gamma          !! mass ratio
    type(dd), intent(in), optional :: omega   !! speed of rotation in the plane of the motion, h/l²; absent: none
    real(dp), intent(in) :: longest        !! the record, l²/h
    type(root_type) :: roots(size(number))
    type(dd) :: alpha(size(number))
    roots = solve_roots(number, gamma)
    alpha = root_values(roots)
    coarse = count(is_coarse(roots%remainder, alpha%hi, omega, longest))
  end function coarse_roots

end module bw_accuracy_ladder
