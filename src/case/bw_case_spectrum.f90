module bw_case_spectrum
  !! What the histories of a case are searched for: amplitude spectra, and waves measured at tip and midpoint.
  use bw_amplitude_spectrum, only: amplitude_spectrum, spectrum_plan
  use bw_case_result, only: case_result, add_note, case_done
  use bw_course, only: held_modes
  use bw_course_histories, only: last_sample
  use bw_kinds, only: dp
  use bw_measured, only: measure_waves
  use bw_mode_check, only: known_modes, measuring_type
  use bw_modes_at_end, only: kind_at_end
  use bw_monitor, only: monitor_type
  use bw_result_layout, only: result_layout
  use bw_scene, only: changes_shapes, scene_type
  use bw_text, only: text_of
  use bw_time_grid, only: time_grid, time_grid_of
  implicit none (type, external)
  private
  public :: take_spectrum

contains

  subroutine take_spectrum(scene, layout, known, plan, monitor, result, whole)
    !! Waves measured from the tip and midpoint histories alone, and amplitude spectra of all points.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(known_modes), allocatable, intent(in) :: known   !! that move after the last event
    type(spectrum_plan), intent(inout) :: plan
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(inout) :: result
    logical, intent(out) :: whole                  !! false where the monitor asked to stop before all was done
    integer :: p
    whole = .true.
    if (.not. allocated(scene%spectrum)) return
    if (result%status /= case_done) call add_note(result, 'no spectrum: the histories are not finished')
    if (layout%middle == 0 .or. layout%tip == 0) then
      call add_note(result, 'measured wave numbers and velocities need the points 0.5 and 1.0, so they are left out')
    else
      ! before the spectra are held, for it needs more memory than they do
      call take_waves(scene, layout, known, monitor, result, whole)
    end if
    if (result%status /= case_done .or. .not. whole) return
    associate (histories => result%response%displacement)
      allocate (result%amplitude(size(histories, 1)/2 + 1, size(histories, 2)))
      do p = 1, size(histories, 2)
        whole = .not. monitor%stop_requested()
        if (.not. whole) return
        call amplitude_spectrum(histories(:, p), scene%spectrum%window, plan, result%amplitude(:, p))
      end do
    end associate
  end subroutine take_spectrum

  subroutine take_waves(scene, layout, known, monitor, result, whole)
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(known_modes), allocatable, intent(in) :: known
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(inout) :: result
    logical, intent(out) :: whole
    type(measuring_type) :: told
    integer :: first, i
    allocate (result%measured)
    first = 1
    if (allocated(result%courses) .and. result%ending == case_done) then
      if (size(result%courses) > 1) first = first_of_last(scene, result)
    end if
    associate (histories => result%response%displacement)
      told%duration = scene%response%duration*(real(size(histories, 1) - first + 1, dp)/size(histories, 1))
      told%length = scene%beam%length
      told%max_peaks = scene%spectrum%max_peaks
      told%uniform = .not. changes_shapes(scene) .and. kind_at_end(scene, result) /= held_modes
      if (allocated(known)) told%known = known
      call measure_waves(histories(first:, layout%tip), histories(first:, layout%middle), told, result%measured, monitor)
    end associate
    whole = .not. monitor%stop_requested()
    if (.not. whole) return
    do i = 1, size(result%measured%notes)
      call add_note(result, result%measured%notes(i)%text)
    end do
  end subroutine take_waves

  integer function first_of_last(scene, result) result(first)
    !! The sample, from 1, with which the last course of the motion begins: waves are measured from there on.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result
    type(time_grid) :: grid
    grid = time_grid_of(scene%response%duration, scene%response%samples, result%units%time)
    first = last_sample(result%courses, size(result%courses) - 1, grid) + 1
    call add_note(result, 'measured: the waves are those of the '//text_of(grid%samples - first + 1)// &
                  ' samples after the last event')
  end function first_of_last

end module bw_case_spectrum
