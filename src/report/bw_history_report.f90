module bw_history_report
  !! The printed report of histories: the largest sample at each point and its time, aliased content, error, largest
  !! stress, and measured waves.
  use bw_case_rows, only: values_of
  use bw_case_result, only: case_result
  use bw_columns, only: fixed, most_rows, short, table_of, text_table
  use bw_constants, only: two_pi
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, scaled
  use bw_response, only: response_type
  use bw_sampled_peak, only: hidden_share, known_samples
  use bw_scene, only: scene_type
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: report_histories, report_measured

  integer, parameter :: shown_points = 5, shown_peaks = 5

contains

  subroutine report_histories(scene, result, lines)
    !! Print a row for each quantity at each point; of many points those of the largest value and the largest error.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    integer :: p
    associate (response => result%response, points => scene%response%points)
      if (response%finite_samples == 0) return     ! a note says why
      call lines%append_line('')
      call lines%append_line('  Histories of '//text_of(result%mode_count)//' modes'//later_counts(result)// &
                             repeat(', motions relative to the base', merge(1, 0, allocated(scene%bases))))
      table = table_of('|xi|largest sample|at|between samples|estimated error|relative|proved bound', '|||s|+ %||%', &
                       [-19, 8, 16, 11, 17, 17, 10, 15], &
                       [(.true., p=1, 7), allocated(response%displacement_bound)], is_list=.false.)
      call table%put_head(lines)
      call report_quantity('displacement', 'm', scene, response%displacement, response%displacement_error, table, &
                           lines, response%displacement_bound)
      if (allocated(response%velocity)) call report_quantity('velocity', 'm/s', scene, response%velocity, &
                                                             response%velocity_error, table, lines)
      if (allocated(response%bending_moment)) call report_quantity('bending moment', 'N m', scene, response%bending_moment, &
        response%bending_moment_error, table, lines)
      if (allocated(response%acceleration)) call report_quantity('acceleration', 'm/s2', scene, response%acceleration, &
        response%acceleration_error, table, lines)
      if (allocated(response%shear_force)) call report_quantity('shear force', 'N', scene, response%shear_force, &
        response%shear_force_error, table, lines)
      call report_stress(scene, response, lines)
      if (size(points) > shown_points) call lines%append_line('  At '//text_of(size(points))//' points; shown are the first, '// &
        'that of the largest history, and that of the largest relative error.')
      if (allocated(scene%recontact)) call lines%append_line( &
        '  The error is the distance from the exact motion of these modes, on whose number a rebound depends.')
      if (allocated(response%displacement_error)) return
      if (allocated(scene%capture)) then
        call lines%append_line('  -: there is no error estimate for a motion beyond the range of double precision.')
      else
        call lines%append_line('  -: a rebound depends on the number of modes: no error against infinitely many is estimated.')
      end if
    end associate
  end subroutine report_histories

  subroutine report_quantity(name, unit, scene, histories, error, table, lines, bound)
    !! Print the rows of one quantity; the first point, mostly where the beam is held, is always shown.
    character(*), intent(in) :: name, unit
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: histories(:, :)           !! (samples, points)
    real(dp), intent(in), optional :: error(:)        !! (points); absent: no estimate
    type(text_table), intent(in) :: table
    type(text_builder), intent(inout) :: lines
    real(dp), intent(in), optional :: bound(:)        !! of the error, (points); absent: not proved
    real(dp), dimension(size(histories, 2)) :: peak, part
    real(dp) :: step
    character(:), allocatable :: head, cells
    logical :: shown(size(peak))
    integer :: p, n, at(size(peak))
    step = scene%response%duration/scene%response%samples
    do p = 1, size(peak)
      n = known_samples(histories(:, p))
      at(p) = maxloc(abs(histories(:n, p)), dim=1)
      peak(p) = -1.0_dp
      if (n > 0) peak(p) = abs(histories(at(p), p))
    end do
    part = 0.0_dp
    if (present(error)) where (peak > 0.0_dp .and. .not. is_missing(error)) part = error/max(peak, 1.0e-6_dp*error)
    shown = size(peak) <= shown_points
    shown(1) = .true.
    shown(maxloc(peak, dim=1)) = .true.
    if (present(error)) shown(maxloc(part, dim=1)) = .true.
    head = '  '//name//', '//unit
    do p = 1, size(peak)
      if (.not. shown(p) .and. size(peak) > most_rows) cycle
      cells = '|-|-|-|-|-'                                     ! no value exists
      if (peak(p) == 0.0_dp) cells = '|0'
      if (peak(p) > 0.0_dp) then
        cells = '|'//fixed(peak(p))//'|'//shortest((at(p) - 1)*step, 5)//'|'// &
          short(scaled(hidden_share(histories(:known_samples(histories(:, p)), p)), 100.0_dp))
        if (.not. present(error)) cells = cells//'|-|-'
        if (present(error)) cells = cells//'|'//short(error(p))//'|'//shortest(100.0_dp*part(p), 2)
        if (present(bound)) cells = cells//'|'//bound_words(bound(p))
      end if
      call table%put_row(lines, head//'|'//shortest(scene%response%points(p), 6)//cells, detail=.not. shown(p))
      head = ''
    end do
  end subroutine report_quantity

  subroutine report_stress(scene, response, lines)
    !! Print the largest sample of bending stress at any point, if the section is known.
    type(scene_type), intent(in) :: scene
    type(response_type), intent(in) :: response
    type(text_builder), intent(inout) :: lines
    real(dp) :: stress(size(scene%response%points))
    integer :: p, at(size(stress))
    if (.not. allocated(response%stress_of_moment)) return
    do p = 1, size(stress)
      associate (moment => response%bending_moment(:known_samples(response%bending_moment(:, p)), p))
        at(p) = maxloc(abs(moment), dim=1)
        stress(p) = 0.0_dp
        if (at(p) > 0) stress(p) = scaled(moment(at(p)), response%stress_of_moment(p))
      end associate
    end do
    p = maxloc(abs(stress), dim=1, mask=.not. is_missing(stress))
    if (p == 0) return
    if (stress(p) == 0.0_dp) return
    call lines%append('  Largest bending stress: '//shortest(abs(stress(p)), 6)//' Pa at xi = '// &
      shortest(scene%response%points(p), 4)//', t = '// &
      shortest((at(p) - 1)*(scene%response%duration/scene%response%samples), 5)//' s, at the extreme fibre')
    if (allocated(response%bending_moment_error)) call lines%append('; estimated numerical error '// &
      short(scaled(response%bending_moment_error(p), response%stress_of_moment(p)))//' Pa')
    call lines%append_line('')
  end subroutine report_stress

  pure function later_counts(result) result(words)
    !! Return further mode counts of a beam that changes in time.
    type(case_result), intent(in) :: result
    character(:), allocatable :: words
    integer :: i
    words = ''
    if (.not. allocated(result%configurations)) return
    do i = 2, size(result%segments)
      if (result%segments(i)%count == result%mode_count .or. words /= '') cycle
      words = ', then of '//text_of(result%segments(i)%count)
    end do
  end function later_counts

  pure function bound_words(bound) result(words)
    !! Round up to two digits.
    real(dp), intent(in) :: bound
    character(:), allocatable :: words
    real(dp) :: shown
    words = '-'
    if (is_missing(bound)) return
    words = shortest(bound, 2)
    read (words, *) shown
    if (shown < bound) words = shortest(bound + 0.5_dp*10.0_dp**(floor(log10(bound)) - 1), 2)
  end function bound_words

  subroutine report_measured(result, lines)
    !! Print waves found in the histories, with error bounds.
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    real(dp), allocatable, dimension(:) :: frequency, bound, wavenumber, phase, group
    type(text_table) :: table
    integer :: shown
    if (result%measured%peak_count == 0) return
    frequency = values_of(result, 'measured_angular_frequency')
    bound = values_of(result, 'measured_angular_frequency_error')
    wavenumber = values_of(result, 'measured_wavenumber')
    phase = values_of(result, 'measured_phase_velocity')
    group = values_of(result, 'measured_group_velocity')
    shown = min(shown_peaks, size(wavenumber))
    call lines%append_line('')
    call lines%append_line('  Measured from the tip and midpoint histories alone; +/- is a bound of the error')
    table = table_of('peak|frequency|+/-|frequency|wave number|phase velocity|group velocity', &
                     '|rad/s|rad/s|Hz|1/m|m/s|m/s', [6, 12, 11, 12, 13, 16, 16])
    call table%put_numbers(lines, shown_peaks, reshape([frequency, bound, frequency/two_pi, wavenumber, phase, group], &
                                                       [size(frequency), 6]), rounded=2)
    if (any(is_missing(wavenumber(:shown))) .and. .not. all(is_missing(wavenumber))) call lines%append_line( &
      '  -: the mode of this peak is uncertain, so that it has no wave number.')
    if (all(is_missing(wavenumber))) call lines%append_line('  -: the notes below say why there are no wave numbers.')
  end subroutine report_measured

end module bw_history_report
