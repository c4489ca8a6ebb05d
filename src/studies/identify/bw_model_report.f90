module bw_model_report
  !! The printed report of a beam compared with its record, and of identified values.
  use bw_corrected_models, only: accepted_share, corrected_model
  use bw_measured_state, only: sensor_error
  use bw_columns, only: right, short, table_of, text_table, to_its_error, to_width
  use bw_constants, only: two_pi
  use bw_fit_search, only: misfit_type, misfit_chance
  use bw_identification, only: identification
  use bw_identify_par, only: identify_par
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_model_comparison, only: compared_lines
  use bw_result_lines, only: result_lines
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: explained_text, loose_text, report_comparison, report_identified, report_corrections

contains

  subroutine report_comparison(title, measured, compared, lines)
    !! Print a row for each line of a case, with its mode.
    character(*), intent(in) :: title            !! of the case
    type(result_lines), intent(in) :: measured
    type(compared_lines), intent(in) :: compared
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    character(:), allocatable :: cells, remark
    integer :: k
    call lines%append_line('')
    call lines%append_line('  '//title)
    table = table_of('line|measured|+/-|mode|computed|difference|over +/-|decay rates', &
                     '|Hz|Hz||Hz|%||over +/-', [6, 14, 11, 6, 14, 12, 12, 14])
    call table%put_head(lines)
    cells = ''
    remark = ''
    do k = 1, size(compared%mode)
      cells = text_of(k)//'|'//to_its_error(measured%angular_frequency(k)/two_pi, measured%error(k)/two_pi)//'|'// &
        shortest(measured%error(k)/two_pi, 2)//'|'
      remark = ''
      if (compared%mode(k) > 0) cells = cells//text_of(compared%mode(k))
      if (compared%mode(k) == 0) cells = cells//'-'
      if (compared%mode(k) == 0 .and. compared%why_none(k) /= '') remark = '   '//trim(compared%why_none(k))
      if (is_missing(compared%frequency(k))) then
        cells = cells//'|-|-'
      else
        cells = cells//'|'//to_its_error(compared%frequency(k)/two_pi, measured%error(k)/two_pi)//'|'// &
          shortest(100*(measured%angular_frequency(k)/compared%frequency(k) - 1), 3)
      end if
      call table%put_row(lines, cells//'|'//short(compared%frequency_misfit(k), 3)//'|'// &
                         short(compared%decay_misfit(k), 3), remark)
    end do
  end subroutine report_comparison

  function explained_text(misfit) result(text)
    !! Report whether noise explains the differences between lines and modes.
    type(misfit_type), intent(in) :: misfit
    character(:), allocatable :: text
    real(dp), parameter :: never = 1.0e-12_dp
    if (misfit%freedom < 1 .and. .not. misfit%tail < misfit_chance) then
      text = 'there are no more lines than unknowns, so that the model is not tested'
      return
    end if
    text = 'chi squared is '//shortest(misfit%chi_squared, 3)//' with '//text_of(misfit%freedom)//' degree'// &
      repeat('s', merge(0, 1, misfit%freedom == 1))//' of freedom; noise alone exceeds it in '
    if (misfit%freedom < 1) text = 'chi squared is '//shortest(misfit%chi_squared, 3)// &
      ' although there are no more lines than unknowns; for one line noise alone exceeds it in '
    if (misfit%tail < never) text = text//'less than one of '//shortest(1/never, 2)//' records'
    if (.not. misfit%tail < never) text = text//shortest(100*misfit%tail, 2)//' % of records'
    if (misfit%aside > 0) text = text//'; lines assigned to no mode: '//text_of(misfit%aside)
    if (misfit%tail < misfit_chance) then
      text = 'the model does not explain the lines: '//text//'. Frequencies are off by '//shortest(100*misfit%scatter, 2)// &
        ' % (one standard deviation)'
    else
      text = 'the model explains the lines: '//text
    end if
    if (misfit%amplitude_error > sensor_error) text = text//'. Amplitudes along the beam are off by '// &
      shortest(100*misfit%amplitude_error, 2)//' % of the largest'
  end function explained_text

  subroutine report_identified(found, confidence, lines)
    !! Print a row for each unknown, and correlated or undetermined unknowns.
    type(identification), intent(in) :: found
    real(dp), intent(in) :: confidence
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    character(:), allocatable :: remark
    real(dp) :: width
    integer :: i
    call lines%append_line('')
    call lines%append_line('  Identified; intervals of '//shortest(100*confidence, 6)//' % by profile likelihood')
    table = table_of('  unknown|value|from|to|unit', '', [-30, 15, 14, 14, 0], is_list=.false.)
    call table%put_head(lines)
    remark = ''
    do i = 1, size(found%values)
      associate (unknown => found%unknowns(i), interval => found%uncertainty%intervals(i))
        width = found%width(i)
        remark = ''
        if (unknown%unit /= '1' .or. interval%low_open .or. interval%high_open) remark = '   '
        if (unknown%unit /= '1') remark = remark//unknown%unit
        if (is_missing(found%low(i)) .or. is_missing(found%high(i))) then
          remark = remark//'; at the end of its range'
        else
          if (interval%low_open) remark = remark//'; from: the end of its range'
          if (interval%high_open) remark = remark//'; to: the end of its range'
        end if
        call table%put_row(lines, '  '//unknown%parameter//'|'//to_width(found%values(i), width)//'|'// &
                           to_width(found%low(i), width)//'|'//to_width(found%high(i), width), remark)
      end associate
    end do
    call report_correlations(found, lines)
    do i = 1, size(found%loose)
      call lines%append_line('  Not fixed: '//loose_text(found, i))
    end do
    do i = 1, size(found%others, 2)
      call lines%append_line('  Equally good fit: '//named_text(found%unknowns, found%others(:, i), '', ''))
    end do
  end subroutine report_identified

  subroutine report_correlations(found, lines)
    !! Report correlations that make an interval twice as wide as with the other unknown known: (1 − ρ²)^(−1/2) ≥ 2.
    type(identification), intent(in) :: found
    type(text_builder), intent(inout) :: lines
    real(dp), parameter :: least = 0.86_dp
    integer :: i, j
    do i = 1, size(found%values)
      do j = i + 1, size(found%values)
        if (abs(found%uncertainty%correlation(i, j)) < least) cycle
        call lines%append_line('  Correlation of '//found%unknowns(i)%parameter//' and '//found%unknowns(j)%parameter//': '// &
                               shortest(found%uncertainty%correlation(i, j), 3))
      end do
    end do
  end subroutine report_correlations

  function loose_text(found, i) result(text)
    !! Report an undetermined unknown and the one that compensates for it, at two places that fit equally well.
    type(identification), intent(in) :: found
    integer, intent(in) :: i
    character(:), allocatable :: text
    associate (loose => found%loose(i))
      text = found%unknowns(loose%unknown)%parameter
      if (loose%partner == 0) then
        text = text//': '//place_text(found, loose%one, [loose%unknown])//' and '// &
          place_text(found, loose%other, [loose%unknown])//' fit equally well'
      else
        text = text//' and '//found%unknowns(loose%partner)%parameter//': '// &
          place_text(found, loose%one, [loose%unknown, loose%partner])//' and '// &
          place_text(found, loose%other, [loose%unknown, loose%partner])//' fit equally well'
      end if
    end associate
  end function loose_text

  function place_text(found, values, which) result(text)
    !! Format values of several unknowns: `0.0044 kg with 0.8`.
    type(identification), intent(in) :: found
    real(dp), intent(in) :: values(:)
    integer, intent(in) :: which(:)
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(which)
      if (i > 1) text = text//' with '
      text = text//with_unit(values(which(i)), found%unknowns(which(i))%unit)
    end do
  end function place_text

  function named_text(unknowns, values, before, behind) result(text)
    !! Format all of them with names: `body%mass = 0.1 kg, body%position = 0.5`; empty if there are none.
    type(identify_par), intent(in) :: unknowns(:)
    real(dp), intent(in) :: values(:)
    character(*), intent(in) :: before, behind
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(values)
      text = text//', '//unknowns(i)%parameter//' = '//with_unit(values(i), unknowns(i)%unit)
    end do
    if (text /= '') text = before//text(3:)//behind
  end function named_text

  function with_unit(value, unit) result(text)
    !! Format a value with its unit: `4.4 kg`.
    real(dp), intent(in) :: value
    character(*), intent(in) :: unit
    character(:), allocatable :: text
    text = shortest(value, 4)
    if (unit /= '1' .and. unit /= '') text = text//' '//unit
  end function with_unit

  subroutine report_corrections(corrections, scatter, lines)
    !! Report corrections of a misfit, the best first, and the number of those tried that do not help.
    type(corrected_model), intent(in) :: corrections(:)      !! sorted by remaining misfit
    real(dp), intent(in) :: scatter              !! τ without corrections
    type(text_builder), intent(inout) :: lines
    integer :: i, helping
    helping = count(corrections%fit%scatter < accepted_share*scatter)
    if (helping > 0) call lines%append_line('  Fitted again with an effect that the model leaves out, or with another value, '// &
                                            'frequencies would be off by')
    do i = 1, helping
      call lines%append(right(shortest(100*corrections(i)%fit%scatter, 2), 10)//' %   '//corrections(i)%effect// &
                        named_text(corrections(i)%unknowns, corrections(i)%values, ' (', ')'))
      if (corrections(i)%fit%scatter <= 0.0_dp) call lines%append('; explains the lines')
      if (corrections(i)%fit%amplitude_error > sensor_error) call lines%append( &
        '; amplitudes are off by '//shortest(100*corrections(i)%fit%amplitude_error, 2)//' %')
      call lines%append_line('')
    end do
    if (helping == 0 .and. size(corrections) > 0) call lines%append_line('  No effect that the model leaves out, and no other '// &
      'value, corrects this; tried: '//text_of(size(corrections)))
    if (helping > 0 .and. helping < size(corrections)) call lines%append_line('  Tried without success: '// &
                                                                              text_of(size(corrections) - helping))
    associate (explaining => corrections%fit%scatter <= 0.0_dp)
      if (count(explaining) > 1 .and. count(explaining .and. corrections%fit%amplitude_error <= sensor_error) /= 1) &
        call lines%append_line('  Several of them explain the lines, which alone cannot distinguish them')
    end associate
  end subroutine report_corrections

end module bw_model_report
